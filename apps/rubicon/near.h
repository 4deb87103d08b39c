#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "rubicon/client.hpp"

namespace rubicon::cli {

class Session;

// What a word that names nothing may have been meant for: `did you mean 'living.lamp-1'?`, or nothing.

/// A point or another tuple. Asks the islands, only when they were met before.
std::string near_tuple(Session& session, std::string_view typed, std::string_view last);
/// The part of it that needs no asking: among these points (`living.lamp-1`, by the number of parts that were typed).
std::string near_point(const std::vector<client::Device>& devices, std::string_view typed);
/// By key part, name, or network and key part.
std::string near_device(const std::vector<client::Device>& devices, std::string_view typed);
/// A type of the catalogue, or of these devices.
std::string near_type(const std::vector<client::Device>& devices, std::string_view typed);

}  // namespace rubicon::cli
