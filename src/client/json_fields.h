#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace rubicon::client {

/// The text of a member; empty when it is missing or of another kind.
inline std::string text_of(const nlohmann::json& tree, const char* name) {
  const auto found = tree.find(name);
  return found != tree.end() && found->is_string() ? found->get<std::string>() : std::string();
}

}  // namespace rubicon::client
