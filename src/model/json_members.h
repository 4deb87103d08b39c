#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "rubicon/time.hpp"

namespace rubicon::model {

/// The text of a member; empty where there is none.
std::string text_of(const nlohmann::ordered_json& tree, const char* name);

/// The same of a sorted tree, for large objects of strangers; nullopt where there is none.
std::optional<std::string> find_text(const nlohmann::json& tree, const char* name);

/// A member in seconds since 1970-01-01 UTC, as a time; {} where there is none from 1970 to the year 5000.
WallTime time_of(const nlohmann::ordered_json& tree, const char* name);

/// On one line; what is no UTF-8 is replaced.
std::string dump(const nlohmann::ordered_json& tree);

}  // namespace rubicon::model
