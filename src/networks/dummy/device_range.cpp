#include "networks/dummy/device_range.h"

#include <fmt/format.h>

#include <optional>

#include "base/text.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::dummy {

namespace {

constexpr std::size_t kMaxDigits = 9;

std::optional<std::size_t> whole_number(std::string_view text) {
  return text.size() > kMaxDigits ? std::nullopt : base::parse_number<std::size_t>(text);
}

}  // namespace

Result<DeviceRange> DeviceRange::parse(std::string_view key) {
  DeviceRange range;
  const auto open = key.find('{');
  const auto dots = key.find("..", open);
  const auto close = key.find('}', dots);
  if (open == key.npos || dots == key.npos || close == key.npos) {
    range.before_ = key;
    return range;
  }
  const auto from = key.substr(open + 1, dots - open - 1);
  const auto to = key.substr(dots + 2, close - dots - 2);
  const auto first = whole_number(from), last = whole_number(to);
  if (!first || !last || *first > *last || key.find('{', close) != key.npos)
    return fail(
        ErrorCode::kInvalid,
        fmt::format("is {}, expected one range of whole numbers, for example room-{{1..100}}", model::quoted(key)));
  range.before_ = key.substr(0, open);
  range.after_ = key.substr(close + 1);
  range.first_ = *first;
  range.last_ = *last;
  range.digits_ = from.starts_with('0') ? from.size() : 0;
  range.is_range_ = true;
  return range;
}

std::string DeviceRange::number(std::size_t index) const {
  return fmt::format("{:0{}}", first_ + index, digits_);
}

std::string DeviceRange::name(const std::string& text, std::size_t index) const {
  const auto at = text.find("{n}");
  if (!is_range_ || at == text.npos) return text;
  return text.substr(0, at) + number(index) + text.substr(at + 3);
}

}  // namespace rubicon::networks::dummy
