#include "proxy/plausibility.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "proxy/naming.h"

namespace rubicon::proxy {

namespace {

constexpr int kBelieved = 3;

struct NoValueCode {
  std::string_view type;
  double code;
};
/// What devices report when they have no value, in the unit of the type, where its range permits it. ZigBee Cluster
/// Library, 2.6.2: each data type has a value that is not valid; 0xffff of 16 bits without a sign, 0x8000 and 0x800000
/// of 16 and 24 bits with one. Of power also in tenths of a watt.
constexpr NoValueCode kNoValueCodes[] = {
    {"power", -32768}, {"power", -3276.8}, {"power", -8388608}, {"power", -838860.8}, {"co2", 65535},
    {"voc", 65535},    {"pm1", 65535},     {"pm25", 65535},     {"pm10", 65535},
};

std::vector<double> codes_of(const model::Type* type) {
  std::vector<double> codes;
  for (const auto& one : kNoValueCodes) {
    if (type && one.type == type->name) codes.push_back(one.code);
  }
  return codes;
}

std::optional<double> number_of(const Value& value) {
  if (const auto* whole = std::get_if<std::int64_t>(&value)) return static_cast<double>(*whole);
  if (const auto* real = std::get_if<double>(&value)) return *real;
  return std::nullopt;
}

/// Devices send numbers of 32 bits, too.
bool same(double a, double b) {
  return std::abs(a - b) <= std::abs(b) * 1e-7;
}

}  // namespace

std::string Plausibility::objection(const Value& value, std::optional<double> before) {
  const auto number = number_of(value);
  if (!number) return {};
  const auto& never = rules_.never;
  if (never && std::any_of(never->begin(), never->end(), [&](double code) { return same(*number, code); }))
    return fmt::format("{} is a code for 'no value'", *number);
  if (rules_.minimum && *number < *rules_.minimum)
    return fmt::format("{} is below the smallest plausible value {}", *number, *rules_.minimum);
  if (rules_.maximum && *number > *rules_.maximum)
    return fmt::format("{} is above the largest plausible value {}", *number, *rules_.maximum);
  auto why = before ? doubt(*number, *before) : std::string();
  agreeing_ = why.empty() ? 0 : agrees(*number) ? agreeing_ + 1 : 1;
  candidate_ = number;
  if (agreeing_ >= kBelieved) {
    agreeing_ = 0;
    return {};
  }
  return why.empty()
             ? why
             : fmt::format("{} (believed when {} readings agree, this is number {})", why, kBelieved, agreeing_);
}

std::string Plausibility::doubt(double value, double before) const {
  if (rules_.rises && value < before)
    return fmt::format("{} is less than {} before, and this counter rises", value, before);
  if (rules_.step && std::abs(value - before) > *rules_.step)
    return fmt::format("{} differs by more than {} from {} before", value, *rules_.step, before);
  return {};
}

bool Plausibility::agrees(double value) const {
  return agreeing_ > 0 && candidate_ && doubt(value, *candidate_).empty();
}

std::optional<Valid> rules_of(const NetworkRules& network, const std::string& address,
                              const model::Capability& capability, const model::Type* type) {
  const auto* device = names_of(network, address);
  const auto own =
      device ? device->valid.find(point_id(nullptr, capability, type)) : std::map<std::string, Valid>::const_iterator();
  const auto of_type = type ? network.valid.find(std::string(type->name)) : network.valid.end();
  Valid rules;
  if (device && own != device->valid.end()) {
    rules = own->second;
  } else if (of_type != network.valid.end()) {
    rules = of_type->second;
  }
  if (!rules.never) rules.never = codes_of(type);
  if (rules.never->empty()) rules.never.reset();
  return rules == Valid{} ? std::nullopt : std::optional(std::move(rules));
}

}  // namespace rubicon::proxy
