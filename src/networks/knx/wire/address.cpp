#include "networks/knx/wire/address.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <span>

#include "base/text.h"

namespace rubicon::networks::knx::wire {

namespace {

struct Part {
  std::string_view name;
  unsigned bits;
};
constexpr std::array kThree{Part{"main group", 5}, Part{"middle group", 3}, Part{"sub group", 8}};
constexpr std::array kTwo{Part{"main group", 5}, Part{"sub group", 11}};
constexpr std::array kOne{Part{"group address", 16}};
constexpr std::array kIndividual{Part{"area", 4}, Part{"line", 4}, Part{"device", 8}};

std::optional<std::uint32_t> decimal(std::string_view text) {
  return text.size() <= 5 ? base::parse_number<std::uint32_t>(text) : std::nullopt;
}

Result<std::uint16_t> parse(std::string_view text, char separator, std::span<const Part> parts) {
  std::uint32_t whole = 0;
  auto rest = text;
  for (const Part& part : parts) {
    const auto cut = std::min(rest.find(separator), rest.size());
    const auto value = decimal(rest.substr(0, cut));
    if (!value)
      return fail(ErrorCode::kInvalid,
                  fmt::format("its {} is '{}', expected a number", part.name, rest.substr(0, cut)));
    const auto most = (1U << part.bits) - 1;
    if (*value > most)
      return fail(ErrorCode::kOutOfRange, fmt::format("its {} is {}, expected 0 to {}", part.name, *value, most));
    whole = whole << part.bits | *value;
    rest.remove_prefix(std::min(cut + 1, rest.size()));
  }
  return static_cast<std::uint16_t>(whole);
}

}  // namespace

Result<GroupAddress> parse_group(std::string_view text) {
  const auto separators = std::count(text.begin(), text.end(), '/');
  if (text.empty() || separators > 2)
    return fail(ErrorCode::kInvalid,
                fmt::format("'{}' is not a group address, expected one like 1/2/7, 1/519 or 2567", text.substr(0, 32)));
  const std::span<const Part> parts = separators == 2   ? std::span<const Part>(kThree)
                                      : separators == 1 ? std::span<const Part>(kTwo)
                                                        : std::span<const Part>(kOne);
  auto value = parse(text, '/', parts);
  if (!value)
    return fail(value.error().code,
                fmt::format("'{}' is not a group address: {}", text.substr(0, 32), value.error().text));
  if (*value == 0) return fail(ErrorCode::kOutOfRange, "0/0/0 is the broadcast address, expected a group address");
  return GroupAddress(*value);
}

std::string to_string(GroupAddress address, Notation notation) {
  const auto value = number(address);
  switch (notation) {
    case Notation::kTwoLevel: return fmt::format("{}/{}", value >> 11, value & 0x7ff);
    case Notation::kFree: return std::to_string(value);
    case Notation::kThreeLevel: break;
  }
  return fmt::format("{}/{}/{}", value >> 11, value >> 8 & 7, value & 0xff);
}

std::string to_key_part(GroupAddress address) {
  const auto value = number(address);
  return fmt::format("{}_{}_{}", value >> 11, value >> 8 & 7, value & 0xff);
}

Result<IndividualAddress> parse_individual(std::string_view text) {
  if (std::count(text.begin(), text.end(), '.') != 2)
    return fail(ErrorCode::kInvalid,
                fmt::format("'{}' is not an individual address, expected one like 1.1.200", text.substr(0, 32)));
  auto value = parse(text, '.', kIndividual);
  if (!value)
    return fail(value.error().code,
                fmt::format("'{}' is not an individual address: {}", text.substr(0, 32), value.error().text));
  return IndividualAddress(*value);
}

std::string to_string(IndividualAddress address) {
  const auto value = number(address);
  return fmt::format("{}.{}.{}", value >> 12, value >> 8 & 0xf, value & 0xff);
}

}  // namespace rubicon::networks::knx::wire
