#include "trust/revoked_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/json_depth.h"
#include "model/json_members.h"
#include "model/json_text.h"
#include "trust/operations.h"
#include "trust/signed_text.h"

namespace rubicon::trust {

namespace {

using Json = nlohmann::json;

constexpr int kForm = 1;
constexpr std::size_t kLevels = 3;
constexpr std::int64_t kLastSecond = 253402300799;  // 9999-12-31
constexpr std::size_t kLongestSerial = 64;

bool is_serial(std::string_view text) {
  return !text.empty() && text.size() <= kLongestSerial && text.find_first_not_of("0123456789ABCDEF") == text.npos;
}

std::int64_t seconds_of(const RevokedCertificate& one) {
  return std::chrono::duration_cast<std::chrono::seconds>(one.when.time_since_epoch()).count();
}

std::optional<RevokedCertificate> certificate_of(const Json& json) {
  if (!json.is_object() || json.size() != 3) return {};
  const auto serial = json.find("serial"), name = json.find("name"), when = json.find("when");
  if (serial == json.end() || name == json.end() || when == json.end()) return {};
  if (!serial->is_string() || !name->is_string() || !when->is_number_unsigned()) return {};
  const auto seconds = when->get<std::uint64_t>();
  RevokedCertificate one{serial->get<std::string>(), name->get<std::string>(), {}};
  if (!is_serial(one.serial) || !check_member_name(one.name) || seconds > kLastSecond) return {};
  one.when = WallTime(std::chrono::seconds(static_cast<std::int64_t>(seconds)));
  return one;
}

std::optional<RevokedList> list_of(const Json& json) {
  if (!json.is_object() || json.size() != 3 || !json.contains("revoked") || json["revoked"] != kForm) return {};
  const auto number = json.find("number"), certificates = json.find("certificates");
  if (number == json.end() || certificates == json.end()) return {};
  if (!number->is_number_unsigned() || !certificates->is_array() || certificates->size() > RevokedList::kMost)
    return {};
  RevokedList list{number->get<std::uint64_t>(), {}};
  for (const auto& item : *certificates) {
    auto one = certificate_of(item);
    if (!one) return {};
    list.certificates.push_back(std::move(*one));
  }
  return list;
}

}  // namespace

const RevokedCertificate* RevokedList::find(std::string_view serial) const {
  const auto found = std::find_if(certificates.begin(), certificates.end(),
                                  [&](const RevokedCertificate& one) { return one.serial == serial; });
  return found == certificates.end() ? nullptr : &*found;
}

bool RevokedList::has_name(std::string_view name) const {
  return std::any_of(certificates.begin(), certificates.end(), [&](const auto& one) { return one.name == name; });
}

Result<std::string> sign_revoked(const RevokedList& list, const Certificate& signer, const PrivateKey& key) {
  if (list.certificates.size() > RevokedList::kMost)
    return fail(ErrorCode::kBusy,
                fmt::format("more than {} certificates are revoked: make a new realm", RevokedList::kMost));
  Json certificates = Json::array();
  for (const auto& one : list.certificates)
    certificates.push_back({{"serial", one.serial}, {"name", one.name}, {"when", seconds_of(one)}});
  const Json json{{"revoked", kForm}, {"number", list.number}, {"certificates", std::move(certificates)}};
  return sign_text(model::dump(json) + "\n", signer, key);
}

Result<RevokedList> parse_revoked(std::string_view json, std::string_view where) {
  const auto wrong = [&] {
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: is no list of at most {} revoked certificates", where, RevokedList::kMost));
  };
  if (json.size() > kLargestSigned || base::is_nested_deeper(json, kLevels)) return wrong();
  const auto parsed = model::parse_json(json);
  if (parsed.is_discarded()) return wrong();
  auto list = list_of(parsed);
  if (!list) return wrong();
  return std::move(*list);
}

Result<RevokedList> read_revoked(std::string_view document, const Certificate& signer, std::string_view where) {
  const auto text = verified_text(document, signer, where);
  if (!text) return fail(text.error());
  return parse_revoked(*text, where);
}

}  // namespace rubicon::trust
