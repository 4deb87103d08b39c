#include "trust/ledger.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "base/text.h"
#include "trust/id_ranges.h"
#include "trust/operations.h"

namespace rubicon::trust {

namespace {

constexpr const char* kBlocksFile = "ca/blocks";
constexpr const char* kMembersFile = "ca/members";
constexpr std::size_t kLargestLedger = 16U << 20U;
constexpr mode_t kLedgerMode = 0600;

char lower(char c) {
  return 'A' <= c && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

bool same_name(std::string_view left, std::string_view right) {
  return std::equal(left.begin(), left.end(), right.begin(), right.end(),
                    [](char a, char b) { return lower(a) == lower(b); });
}

/// `desk 5A.. 1893456000`.
std::optional<LedgerEntry> entry_of(std::string_view line) {
  const auto first = line.find(' ');
  const auto second = first == line.npos ? first : line.find(' ', first + 1);
  if (second == line.npos) return {};
  const auto seconds = base::parse_number<std::int64_t>(line.substr(second + 1));
  LedgerEntry entry{std::string(line.substr(0, first)), std::string(line.substr(first + 1, second - first - 1)), {}};
  if (!seconds || *seconds < 0 || *seconds > 253402300799 || !check_member_name(entry.name) || entry.serial.empty() ||
      entry.serial.find_first_not_of("0123456789ABCDEF") != entry.serial.npos)
    return {};
  entry.ends = WallTime(std::chrono::seconds(*seconds));
  return entry;
}

Result<std::vector<LedgerEntry>> parse_entries(std::string_view text, const std::string& where) {
  std::vector<LedgerEntry> entries;
  for (std::size_t line = 1; !text.empty(); ++line) {
    const auto end = text.find('\n');
    auto entry = entry_of(text.substr(0, end));
    if (!entry || end == text.npos)
      return fail(ErrorCode::kInvalid, fmt::format("{}:{}: expected a name, the serial number of its certificate, and "
                                                   "its end in seconds after 1970",
                                                   where, line));
    entries.push_back(std::move(*entry));
    text.remove_prefix(end + 1);
  }
  return entries;
}

}  // namespace

Result<Ledger> Ledger::read(const TrustFolder& folder) {
  Ledger ledger;
  const auto& files = folder.files();
  const auto blocks = files.read(kBlocksFile, 64);
  if (!blocks) return fail(blocks.error());
  const auto last = base::parse_number<std::uint32_t>(base::trimmed(*blocks));
  if (!last || *last > kLastBlock)
    return fail(ErrorCode::kInvalid, fmt::format("{}: expected the number of the last block of ids, 0 to {}",
                                                 files.path(kBlocksFile), kLastBlock));
  ledger.last_block_ = *last;
  const auto members = files.read(kMembersFile, kLargestLedger);
  if (!members) return fail(members.error());
  auto entries = parse_entries(*members, files.path(kMembersFile));
  if (!entries) return fail(entries.error());
  ledger.entries_ = std::move(*entries);
  for (const auto& name : folder.members()) {
    const auto member = folder.member(name);
    // One that cannot be read says nothing about this list, but a name without any certificate in it does.
    if (!member && ledger.of_name(name).empty()) return fail(member.error());
    if (!member) continue;
    if (auto checked = ledger.check_member(*member, folder); !checked) return fail(checked.error());
  }
  return ledger;
}

Result<void> Ledger::check_member(const tuples::Member& member, const TrustFolder& folder) const {
  const bool known = std::any_of(entries_.begin(), entries_.end(), [&](const LedgerEntry& entry) {
    return entry.name == member.name && entry.serial == member.serial && entry.ends == member.expires;
  });
  const auto& files = folder.files();
  if (!known)
    return fail(
        ErrorCode::kInvalid,
        fmt::format("{}: does not have the certificate of {} with the serial number {} ({}): expected all that "
                    "were given",
                    files.path(kMembersFile), member.name, member.serial, files.path(certificate_file(member.name))));
  for (const auto& range : member.ids) {
    if (block_of(range) > last_block_)
      return fail(ErrorCode::kInvalid,
                  fmt::format("{}: says {}, but {} has block {}", files.path(kBlocksFile), last_block_,
                              files.path(certificate_file(member.name)), block_of(range)));
  }
  return {};
}

Result<void> Ledger::write(const TrustFolder& folder) const {
  const auto& files = folder.files();
  std::string text;
  for (const auto& entry : entries_) {
    const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(entry.ends.time_since_epoch()).count();
    text += fmt::format("{} {} {}\n", entry.name, entry.serial, seconds);
  }
  if (auto written = files.write(kBlocksFile, fmt::format("{}\n", last_block_), kLedgerMode); !written) return written;
  return files.write(kMembersFile, text, kLedgerMode);
}

bool Ledger::has_name(std::string_view name) const {
  return std::any_of(entries_.begin(), entries_.end(),
                     [&](const LedgerEntry& entry) { return same_name(entry.name, name); });
}

std::vector<LedgerEntry> Ledger::of_name(std::string_view name) const {
  std::vector<LedgerEntry> found;
  std::copy_if(entries_.begin(), entries_.end(), std::back_inserter(found),
               [&](const LedgerEntry& entry) { return entry.name == name; });
  return found;
}

Result<std::uint32_t> Ledger::take_block() {
  if (last_block_ >= kLastBlock)
    return fail(ErrorCode::kBusy, fmt::format("all {} blocks of ids are given away: make a new realm", kLastBlock));
  return ++last_block_;
}

}  // namespace rubicon::trust
