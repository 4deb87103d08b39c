#include "web/exchange.h"

#include <algorithm>

namespace rubicon::web {

namespace {

std::optional<std::string_view> first_value(const Fields& fields, std::string_view name) {
  const auto found =
      std::find_if(fields.begin(), fields.end(), [name](const auto& field) { return field.first == name; });
  if (found == fields.end()) return std::nullopt;
  return found->second;
}

}  // namespace

std::string_view Request::header(std::string_view name) const {
  return first_value(headers, name).value_or(std::string_view());
}

std::optional<std::string_view> Request::parameter(std::string_view name) const {
  return first_value(query, name);
}

bool is_site_path(std::string_view path) {
  return path == "/api" || path.starts_with("/api/") || path == "/metrics" || path == "/healthz";
}

}  // namespace rubicon::web
