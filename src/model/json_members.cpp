#include "model/json_members.h"

#include <cmath>

namespace rubicon::model {

std::string text_of(const nlohmann::ordered_json& tree, const char* name) {
  const auto found = tree.find(name);
  return found != tree.end() && found->is_string() ? found->get<std::string>() : std::string();
}

std::optional<std::string> find_text(const nlohmann::json& tree, const char* name) {
  const auto found = tree.find(name);
  if (found == tree.end() || !found->is_string()) return std::nullopt;
  return found->get<std::string>();
}

WallTime time_of(const nlohmann::ordered_json& tree, const char* name) {
  constexpr double kLatest = 1e11;  // beyond the year 5000
  const auto found = tree.find(name);
  const auto seconds = found != tree.end() && found->is_number() ? found->get<double>() : 0;
  if (!(seconds > 0 && seconds < kLatest)) return {};
  return WallTime(std::chrono::microseconds(std::llround(seconds * 1e6)));
}

std::string dump(const nlohmann::ordered_json& tree) {
  return tree.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace rubicon::model
