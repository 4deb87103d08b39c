#include "apps/rubicon/time_option.h"

#include <ctime>

#include "base/config_reader.h"
#include "base/text.h"

namespace rubicon::cli {

namespace {

std::string check_time(const std::string& text) {
  if (time_in(text, WallTime(std::chrono::hours(24 * 20'000)))) return {};
  return text + ": expected now, a span before it (2h), seconds since 1970, or 2026-01-31T12:00:00Z";
}

}  // namespace

CLI::Option* add_time_option(CLI::App* app, const std::string& name, std::string& text, const std::string& about) {
  return app->add_option(name, text, about)->type_name("TIME")->check(check_time);
}

std::optional<WallTime> time_in(const std::string& text, WallTime now) {
  if (text == "now") return now;
  if (const auto span = base::parse_duration(text))
    return now - std::chrono::duration_cast<std::chrono::microseconds>(*span);
  if (const auto seconds = base::parse_number<double>(text)) {
    const auto time = model::time_from_seconds(*seconds);
    return time == WallTime() ? std::nullopt : std::optional(time);
  }
  std::tm calendar{};
  const auto* end = ::strptime(text.c_str(), "%Y-%m-%dT%H:%M:%SZ", &calendar);
  if (end == nullptr || *end != '\0') return std::nullopt;
  return WallTime(std::chrono::seconds(::timegm(&calendar)));
}

}  // namespace rubicon::cli
