#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "rubicon/client.hpp"

namespace rubicon::cli {

class Session;

// Suggestions for a word that matches nothing: `did you mean 'living.lamp-1'?`; empty where nothing is similar.

/// A point or another tuple. Asks the islands if they were discovered before.
std::string suggest_tuple(Session& session, std::string_view typed, std::string_view last);
/// Among the points of these devices (`living.lamp-1`, by the number of parts that were typed).
std::string suggest_point(const std::vector<client::Device>& devices, std::string_view typed);
/// By key part, name, or network and key part.
std::string suggest_device(const std::vector<client::Device>& devices, std::string_view typed);
/// A type of the catalogue, or of these devices.
std::string suggest_type(const std::vector<client::Device>& devices, std::string_view typed);

}  // namespace rubicon::cli
