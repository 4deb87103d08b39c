#include "web/exchange.h"

#include <algorithm>
#include <array>

#include "base/text.h"
#include "model/json_members.h"
#include "model/message.h"
#include "model/point_keys.h"

namespace rubicon::web {

namespace {

std::string_view after_first_part(std::string_view key) {
  const auto dot = key.find('.');
  return dot == key.npos ? std::string_view() : key.substr(dot + 1);
}

/// `NETWORK.DEVICE.description` behind the prefix: a set gives the device its name and room.
bool is_description_of_device(std::string_view rest) {
  return rest.ends_with(".description") && std::count(rest.begin(), rest.end(), '.') == 2;
}

/// Keys below the prefix of an island, whatever that is, that change how the island works, or what devices are called;
/// and the messages of its gateway, which may say anything. Longer keys of the same branch are points of a network that
/// has its name.
bool steers_island(std::string_view key) {
  constexpr std::array<std::string_view, 4> kBranches{"inbox", "settings", "recorder", "log"};
  constexpr auto kMaxDots = 2;  // inbox.NETWORK.ADDRESS, recorder.NAME.command
  const auto first = key.substr(0, key.find('.'));
  if (first == "GATEWAY" || first == "RUBICON_GATEWAY" || model::is_line_command(key)) return true;
  const auto rest = after_first_part(key);
  if (is_description_of_device(rest)) return true;
  const bool is_branch =
      std::find(kBranches.begin(), kBranches.end(), rest.substr(0, rest.find('.'))) != kBranches.end();
  return is_branch && std::count(rest.begin(), rest.end(), '.') <= kMaxDots;
}

}  // namespace

bool may(const Caller& caller, Verb verb, OwnerId, std::string_view key) {
  switch (verb) {
    case Verb::kRead:
    case Verb::kWake: return caller.role >= Role::kView;
    case Verb::kSet: return caller.role >= (steers_island(key) ? Role::kAdmin : Role::kCommand);
    case Verb::kSend: return caller.role >= (model::is_admin_type(key) ? Role::kAdmin : Role::kCommand);
  }
  return false;
}

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

namespace {

unsigned status_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::kNotFound: return 404;
    case ErrorCode::kRefused: return 403;
    case ErrorCode::kUnsupported: return 501;
    case ErrorCode::kBusy: return 429;
    case ErrorCode::kDuplicate: return 409;
    case ErrorCode::kUnreachable: return 503;
    case ErrorCode::kExpired: return 504;
    case ErrorCode::kIo: return 500;
    case ErrorCode::kInvalid:
    case ErrorCode::kOutOfRange: break;
  }
  return 400;
}

}  // namespace

Response error_response(unsigned status, ErrorCode code, std::string_view text) {
  return {.status = status,
          .content_type = "application/json",
          .body = model::dump({{"error", {{"code", to_string(code)}, {"text", text}}}})};
}

Response error_response(const Error& error) {
  return error_response(status_of(error.code), error.code, error.text);
}

Response refusal_of(const Error& error) {
  auto response = error_response(error.code == ErrorCode::kBusy ? 429 : 401, error.code, error.text);
  if (error.code == ErrorCode::kBusy) {
    response.headers.emplace_back("Retry-After", "60");
  } else {
    response.headers.emplace_back("WWW-Authenticate", "Bearer");
  }
  return response;
}

}  // namespace rubicon::web
