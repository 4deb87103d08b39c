#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "networks/knx/dpt/dpt.h"
#include "rubicon/key.hpp"

#include "base/text.h"

namespace rubicon::networks::knx::dpt {

namespace {

/// At most five digits. 65535 means "main type only" and is no valid number.
std::optional<std::uint16_t> number_of(std::string_view text) {
  if (text.size() > 5) return std::nullopt;
  const auto number = base::parse_number<std::uint16_t>(text);
  return number != DptId::kMainOnly ? number : std::nullopt;
}

bool drop_word(std::string_view& text, std::string_view word) {
  const auto same = [](char a, char b) { return (a >= 'a' && a <= 'z' ? a - 'a' + 'A' : a) == b; };
  if (text.size() < word.size() ||
      !std::equal(word.begin(), word.end(), text.begin(), [same](char b, char a) { return same(a, b); })) {
    return false;
  }
  text.remove_prefix(word.size());
  return true;
}

std::optional<DptId> numbers_of(std::string_view text, char between) {
  const auto cut = text.find(between);
  const auto main = number_of(text.substr(0, cut));
  if (!main || *main == 0) return std::nullopt;
  if (cut == text.npos) return DptId{*main, DptId::kMainOnly};
  const auto rest = text.substr(cut + 1);
  if (rest == "*") return DptId{*main, DptId::kMainOnly};
  const auto sub = number_of(rest);
  if (!sub) return std::nullopt;
  return DptId{*main, *sub};
}

}  // namespace

Result<DptId> parse_dpt(std::string_view text) {
  auto rest = text;
  std::optional<DptId> found;
  if (drop_word(rest, "DPST-")) {
    found = numbers_of(rest, '-');
    if (found && found->sub == DptId::kMainOnly) found.reset();
  } else {
    if (drop_word(rest, "DPT") && rest.starts_with('-')) rest.remove_prefix(1);
    found = numbers_of(rest, '.');
  }
  if (found) return *found;
  return fail(ErrorCode::kInvalid,
              fmt::format("data point type {}: expected 9.001, DPT9.001, DPST-9-1 or DPT-9", model::quoted(text)));
}

std::string to_string(DptId id) {
  if (id.sub == DptId::kMainOnly) return fmt::format("{}.*", id.main);
  return fmt::format("{}.{:03}", id.main, id.sub);
}

}  // namespace rubicon::networks::knx::dpt
