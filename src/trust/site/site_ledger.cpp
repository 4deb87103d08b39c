#include "trust/site/site_ledger.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "base/text.h"
#include "trust/site/user_names.h"

namespace rubicon::trust::site {

namespace {

constexpr const char* kEntriesFile = "ca/certificates";
constexpr std::size_t kLargestEntries = 16UL << 20U;
constexpr mode_t kEntriesMode = 0600;
constexpr std::int64_t kLastSecond = 253402300799;  // 9999-12-31
constexpr std::string_view kNothing = "-";

char in_lower_case(char c) {
  return 'A' <= c && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

bool is_same_user(std::string_view left, std::string_view right) {
  return std::equal(left.begin(), left.end(), right.begin(), right.end(),
                    [](char a, char b) { return in_lower_case(a) == in_lower_case(b); });
}

std::int64_t in_seconds(WallTime time) {
  return std::chrono::duration_cast<std::chrono::seconds>(time.time_since_epoch()).count();
}

std::optional<WallTime> time_in(std::string_view text) {
  const auto seconds = base::parse_number<std::int64_t>(text);
  if (!seconds || *seconds < 0 || *seconds > kLastSecond) return {};
  return WallTime(std::chrono::seconds(*seconds));
}

/// `desk 5A.. 1893456000 -`, `ann - 0 1767225600`: user, serial number, end, when it was revoked.
std::optional<SiteEntry> entry_in(std::string_view line) {
  std::array<std::string_view, 4> words;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const auto end = line.find(' ');
    if ((end == line.npos) != (i + 1 == words.size())) return {};
    words[i] = line.substr(0, end);
    if (end != line.npos) line.remove_prefix(end + 1);
  }
  const auto [user, serial, ends, revoked] = words;
  const bool no_serial = serial == kNothing;
  if (!check_user_name(user) || serial.empty() ||
      (!no_serial && serial.find_first_not_of("0123456789ABCDEF") != serial.npos))
    return {};
  const auto end = time_in(ends), when = revoked == kNothing ? std::nullopt : time_in(revoked);
  if (!end || (revoked != kNothing && !when)) return {};
  return SiteEntry{std::string(user), no_serial ? std::string() : std::string(serial), *end, when};
}

}  // namespace

Result<SiteLedger> SiteLedger::read(const SiteFolder& folder) {
  const auto& files = folder.files();
  const auto text = files.read(kEntriesFile, kLargestEntries);
  if (!text) return fail(text.error());
  SiteLedger ledger;
  std::string_view rest = *text;
  for (std::size_t line = 1; !rest.empty(); ++line) {
    const auto end = rest.find('\n');
    auto entry = entry_in(rest.substr(0, end));
    if (!entry || end == rest.npos)
      return fail(ErrorCode::kInvalid,
                  fmt::format("{}:{}: expected a name, the serial number of its certificate, its end and when it was "
                              "revoked, in seconds after 1970",
                              files.path(kEntriesFile), line));
    ledger.entries_.push_back(std::move(*entry));
    rest.remove_prefix(end + 1);
  }
  return ledger;
}

Result<void> SiteLedger::write(const SiteFolder& folder) const {
  std::string text;
  for (const auto& one : entries_)
    text += fmt::format("{} {} {} {}\n", one.user, one.has_certificate() ? one.serial : kNothing, in_seconds(one.ends),
                        one.revoked ? fmt::format("{}", in_seconds(*one.revoked)) : kNothing);
  return folder.files().write(kEntriesFile, text, kEntriesMode);
}

bool SiteLedger::has_name(std::string_view user) const {
  return std::any_of(entries_.begin(), entries_.end(), [&](const auto& one) { return is_same_user(one.user, user); });
}

void SiteLedger::revoke(std::string_view user, WallTime when) {
  for (auto& one : entries_) {
    if (one.user == user && !one.revoked) one.revoked = std::chrono::floor<std::chrono::seconds>(when);
  }
}

std::vector<RevokedSerial> SiteLedger::revoked(WallTime now) const {
  std::vector<RevokedSerial> all;
  for (const auto& one : entries_) {
    if (one.has_certificate() && one.revoked && !one.has_ended(now)) all.push_back({one.serial, *one.revoked});
  }
  return all;
}

bool SiteLedger::has_ended(std::string_view user, WallTime now) const {
  return std::all_of(entries_.begin(), entries_.end(),
                     [&](const auto& one) { return one.user != user || one.has_ended(now); });
}

}  // namespace rubicon::trust::site
