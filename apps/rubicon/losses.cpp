#include "apps/rubicon/losses.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "apps/rubicon/secure_findings.h"
#include "base/text.h"

namespace rubicon::cli {

bool counts_loss(std::string_view name) {
  if (is_secure_counter(name)) return true;
  if (name == "dds-refused-peers") return false;  // strangers; check_island_trust() has them
  constexpr std::array<std::string_view, 22> kWords{
      "dropped",     "lost",     "refused", "undeliverable", "undelivered", "undecodable", "malformed",  "looped",
      "damaged",     "failures", "failed",  "bad",           "cut",         "missing",     "undeclared", "unknown",
      "unconfirmed", "expired",  "skipped", "not",           "forged",      "implausible"};
  while (!name.empty()) {
    const auto word = name.substr(0, name.find('-'));
    if (std::find(kWords.begin(), kWords.end(), word) != kWords.end()) return true;
    name.remove_prefix(std::min(name.size(), word.size() + 1));
  }
  return false;
}

Counters counters_of(const std::map<std::string, std::string>& properties) {
  Counters counters;
  for (const auto& [name, text] : properties) {
    if (const auto number = base::parse_number<std::uint64_t>(text)) counters[name] = *number;
  }
  return counters;
}

Counters losses_of(const Counters& counters) {
  Counters losses;
  for (const auto& [name, count] : counters) {
    if (count > 0 && counts_loss(name)) losses[name] = count;
  }
  return losses;
}

Counters growth_of(const Counters& before, const Counters& now) {
  Counters growth;
  for (const auto& [name, count] : now) {
    const auto known = before.find(name);
    const auto start = known == before.end() || known->second > count ? 0 : known->second;
    if (count > start) growth[name] = count - start;
  }
  return growth;
}

std::string losses_text(const Counters& losses, const Counters& growth) {
  std::string text;
  for (const auto& [name, count] : losses) {
    const auto grown = growth.find(name);
    text += fmt::format("{}{} {}{}", text.empty() ? "" : ", ", name, count,
                        grown == growth.end() ? "" : fmt::format(" (+{})", grown->second));
  }
  return text;
}

}  // namespace rubicon::cli
