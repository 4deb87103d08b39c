#include "model/json_text.h"

#include <nlohmann/json.hpp>

namespace rubicon::model {

nlohmann::json parse_json(std::string_view text) {
  return nlohmann::json::parse(text, nullptr, false);
}

nlohmann::ordered_json parse_ordered_json(std::string_view text) {
  return nlohmann::ordered_json::parse(text, nullptr, false);
}

bool is_json(std::string_view text) {
  return nlohmann::json::accept(text);
}

std::string dump(const nlohmann::ordered_json& tree) {
  return tree.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

std::string dump_sorted(const nlohmann::json& tree) {
  return tree.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string dump_ascii(const nlohmann::json& tree) {
  return tree.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
}

}  // namespace rubicon::model
