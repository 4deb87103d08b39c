#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "client/names.h"
#include "rubicon/client.hpp"

namespace rubicon::cli {

class Session;

// Suggestions for a word that matches nothing: `did you mean 'living.lamp-1'?`; empty where nothing is similar.

/// A point, also by what people call it, or another tuple; a point that has the tuple `last` (`value`, `command`), so
/// for a command one that can be set.
std::string suggest_tuple(Session& session, std::string_view typed, std::string_view last);
/// Among points, by their keys (`living.lamp-1`, by the number of parts that were typed).
std::string suggest_point(const std::vector<std::string>& keys, std::string_view typed);
/// `of living can be set: 'living.lamp-1' or 'living.blind-1'`, for a point that can only be read.
std::string suggest_settable(Session& session, OwnerId island, std::string_view point);
/// By key part, name, area, or network and key part.
std::string suggest_device(const client::KnownNames& names, std::string_view typed);
/// The types of the catalogue and of these devices, with their models.
std::vector<std::string> type_words(const std::vector<client::Device>& devices);
/// One of these types.
std::string suggest_type(const std::vector<client::Device>& devices, std::string_view typed);

}  // namespace rubicon::cli
