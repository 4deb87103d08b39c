#include "web/api/query.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/config_reader.h"
#include "base/nearest.h"
#include "base/text.h"
#include "model/json_members.h"

namespace rubicon::web::api {

void Query::fault(std::string text) {
  if (!fault_) fault_ = Error{ErrorCode::kInvalid, std::move(text)};
}

void Query::wrong(std::string_view name, std::string_view got, std::string_view expected) {
  fault(fmt::format("{} is {}; expected {}", name, model::quoted(got), expected));
}

const std::string* Query::find(std::string_view name) {
  known_.emplace_back(name);
  for (const auto& [key, value] : request_.query) {
    if (key == name) return &value;
  }
  return nullptr;
}

bool Query::has(std::string_view name) {
  return find(name) != nullptr;
}

std::string Query::text(std::string_view name) {
  const auto* got = find(name);
  return got ? *got : std::string();
}

std::vector<std::string> Query::texts(std::string_view name) {
  known_.emplace_back(name);
  std::vector<std::string> all;
  for (const auto& [key, value] : request_.query) {
    if (key == name) all.push_back(value);
  }
  return all;
}

std::uint64_t Query::count(std::string_view name, std::uint64_t otherwise, std::uint64_t least, std::uint64_t most) {
  const auto* got = find(name);
  if (got == nullptr) return otherwise;
  const auto number = base::parse_number<std::uint64_t>(*got);
  if (number && *number >= least && *number <= most) return *number;
  wrong(name, *got, fmt::format("a whole number from {} to {}", least, most));
  return otherwise;
}

std::optional<std::uint64_t> Query::count(std::string_view name) {
  if (!request_.parameter(name)) return has(name), std::nullopt;
  return count(name, 0, 0, UINT64_MAX);
}

double Query::number(std::string_view name, double otherwise, double least, double most) {
  const auto* got = find(name);
  if (got == nullptr) return otherwise;
  const auto number = base::parse_number<double>(*got);
  if (number && *number >= least && *number <= most) return *number;
  wrong(name, *got, fmt::format("a number from {} to {}", least, most));
  return otherwise;
}

Duration Query::duration(std::string_view name, Duration otherwise, Duration longest) {
  const auto* got = find(name);
  if (got == nullptr) return otherwise;
  const auto length = base::parse_duration(*got);
  if (length && *length >= Duration(0) && *length <= longest) return *length;
  wrong(name, *got, "a time such as 250ms, 5s or 10min");
  return otherwise;
}

WallTime Query::time(std::string_view name, WallTime otherwise, WallTime now) {
  const auto* got = find(name);
  if (got == nullptr) return otherwise;
  if (got->starts_with('-')) {
    const auto ago = base::parse_duration(std::string_view(*got).substr(1));
    if (ago) return now - std::chrono::duration_cast<std::chrono::microseconds>(*ago);
  }
  const auto seconds = base::parse_number<double>(*got);
  const auto time = seconds ? model::time_from_seconds(*seconds) : WallTime{};
  if (time != WallTime{}) return time;
  wrong(name, *got, "seconds since 1970, or a time before now such as -1h");
  return otherwise;
}

bool Query::flag(std::string_view name) {
  const auto* got = find(name);
  if (got == nullptr || *got == "false" || *got == "0") return false;
  if (got->empty() || *got == "true" || *got == "1") return true;
  wrong(name, *got, "true or false");
  return false;
}

Pattern Query::pattern(std::string_view name) {
  const auto* got = find(name);
  if (got == nullptr) return fault(fmt::format("{} is missing; expected OWNER:KEY or *:KEY", name)), Pattern{};
  auto pattern = Pattern::parse(*got);
  if (pattern) return std::move(*pattern);
  fault(fmt::format("{}: {}", name, pattern.error().text));
  return {};
}

Result<void> Query::end() {
  if (fault_) return fail(*fault_);
  for (const auto& [name, unused] : request_.query) {
    if (std::find(known_.begin(), known_.end(), name) != known_.end()) continue;
    const auto near = base::did_you_mean(name, known_);
    return fail(ErrorCode::kInvalid,
                fmt::format("unknown parameter {}{}{}", model::quoted(name), near.empty() ? "" : "; ", near));
  }
  return {};
}

}  // namespace rubicon::web::api
