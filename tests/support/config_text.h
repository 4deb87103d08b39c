#pragma once

#include <nlohmann/json.hpp>
#include <string_view>

#include "base/config_reader.h"

namespace rubicon::support {

inline ConfigNode config_of(const nlohmann::ordered_json& json) {
  ConfigNode node;
  if (json.is_object()) {
    node.kind = ConfigNode::Kind::kMap;
    for (const auto& [key, entry] : json.items()) node.entries.emplace_back(key, config_of(entry));
  } else if (json.is_array()) {
    node.kind = ConfigNode::Kind::kList;
    for (const auto& item : json) node.items.push_back(config_of(item));
  } else if (!json.is_null()) {
    node.kind = ConfigNode::Kind::kScalar;
    node.text = json.is_string() ? json.get<std::string>() : json.dump();
  }
  return node;
}

/// A configuration for tests below the YAML reader, written as JSON.
inline ConfigNode config_of(std::string_view json) {
  return config_of(nlohmann::ordered_json::parse(json));
}

}  // namespace rubicon::support
