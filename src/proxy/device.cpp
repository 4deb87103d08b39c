#include "proxy/device.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <string_view>

#include "base/prefetch.h"
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

const Type* known_type(const TypeCatalogue& types, const Capability& capability, const model::OpenType* own) {
  if (const auto* known = types.find(capability.point.type)) return known;
  return own ? &own->type() : nullptr;
}

}  // namespace

std::string Plausibility::objection(const Value& value, std::optional<double> before) {
  const auto number = number_of(value);
  if (!number) return {};
  const auto& never = rules_->never;
  if (never && std::any_of(never->begin(), never->end(), [&](double code) { return same(*number, code); }))
    return fmt::format("{} is a code for 'no value'", *number);
  if (rules_->minimum && *number < *rules_->minimum)
    return fmt::format("{} is below the smallest plausible value {}", *number, *rules_->minimum);
  if (rules_->maximum && *number > *rules_->maximum)
    return fmt::format("{} is above the largest plausible value {}", *number, *rules_->maximum);
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
  if (rules_->rises && value < before)
    return fmt::format("{} is less than {} before, and this counter rises", value, before);
  if (rules_->step && std::abs(value - before) > *rules_->step)
    return fmt::format("{} differs by more than {} from {} before", value, *rules_->step, before);
  return {};
}

bool Plausibility::agrees(double value) const {
  return agreeing_ > 0 && candidate_ && doubt(value, *candidate_).empty();
}

std::shared_ptr<const Valid> SharedRules::of(Valid rules) {
  for (const auto& one : known_) {
    if (auto known = one.lock(); known && *known == rules) return known;
  }
  if (known_.size() >= kMax) std::erase_if(known_, [](const auto& one) { return one.expired(); });
  auto fresh = std::make_shared<const Valid>(std::move(rules));
  if (known_.size() < kMax) known_.push_back(fresh);
  return fresh;
}

std::optional<Valid> rules_of(const NetworkRules& network, const std::string& address,
                              const PointCapability& capability) {
  const auto* type = capability.type;
  const auto* device = names_of(network, address);
  const auto own = device ? device->valid.find(capability.id) : std::map<std::string, Valid>::const_iterator();
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

PointCapability::PointCapability(const Capability& capability, const TypeCatalogue& types)
    : Capability(capability),
      own_type_(capability.data ? std::make_unique<model::OpenType>(capability) : nullptr),
      type(known_type(types, capability, own_type_.get())),
      id(point_id(nullptr, capability, type)) {}

std::shared_ptr<const PointCapability> SharedCapabilities::of(const Capability& capability) {
  const auto hash =
      std::hash<std::string>{}(capability.point.instance) * 31 + static_cast<std::size_t>(capability.point.type);
  const auto [first, last] = known_.equal_range(hash);
  for (auto one = first; one != last; ++one) {
    if (auto known = one->second.lock(); known && static_cast<const Capability&>(*known) == capability) return known;
  }
  if (known_.size() >= kMax) std::erase_if(known_, [](const auto& one) { return one.second.expired(); });
  auto fresh = std::make_shared<const PointCapability>(capability, types_);
  if (known_.size() < kMax) known_.emplace(hash, fresh);
  return fresh;
}

// A KNX import lists tens of thousands of points: bench/point_bench measures what each costs.
static_assert(sizeof(Point) <= 192);
static_assert(sizeof(Device) <= 464);

std::uint32_t DeviceTable::hash_of(std::string_view address) {
  return static_cast<std::uint32_t>(std::uint64_t{std::hash<std::string_view>()(address)} >> 32);
}

Device* DeviceTable::find(std::string_view address, std::uint32_t hash) const {
  const auto found = index_.find(hash, [&](std::uint32_t at) { return devices_[at]->address == address; });
  return found == base::HashIndex::kNone ? nullptr : devices_[found].get();
}

void DeviceTable::fetch_device(std::uint32_t hash) const {
  const auto guess = index_.guess(hash);
  if (guess == base::HashIndex::kNone) return;
  base::prefetch(devices_[guess].get());
  base::prefetch(&devices_[guess]->address);
}

Device& DeviceTable::add(const std::string& address) {
  index_.add(hash_of(address), static_cast<std::uint32_t>(devices_.size()));
  auto& device = *devices_.emplace_back(std::make_unique<Device>());
  device.address = address;
  return device;
}

void DeviceTable::remove(const Device& device) {
  const auto hash = hash_of(device.address);
  const auto place = index_.find(hash, [&](std::uint32_t at) { return devices_[at].get() == &device; });
  const auto last = static_cast<std::uint32_t>(devices_.size() - 1);
  index_.remove(hash, place);
  if (place != last) {
    const auto moved = hash_of(devices_[last]->address);
    index_.remove(moved, last);
    index_.add(moved, place);
    devices_[place].swap(devices_[last]);
  }
  devices_.pop_back();
}

std::string_view to_string(DeviceStatus status) {
  switch (status) {
    case DeviceStatus::kUnknown: return "unknown";
    case DeviceStatus::kReachable: return "reachable";
    case DeviceStatus::kUnreachable: return "unreachable";
  }
  return "unknown";
}

bool is_event(const Point& point) {
  return (point.type ? point.type->report : point.details->capability->report) == model::Report::kEvent;
}

bool is_rate(const Point& point) {
  const bool of_device = point.id.kind == Kind::kProperty && point.id.instance.empty();
  return of_device && point.type && point.type->name == "rate" && !model::is_open(point.id.type);
}

std::optional<std::chrono::milliseconds> rate_of(const Value& value) {
  constexpr std::chrono::milliseconds kMaxRate = std::chrono::hours(24);
  const auto* whole = std::get_if<std::int64_t>(&value);
  if (!whole || *whole < 1 || *whole > kMaxRate.count()) return std::nullopt;
  return std::chrono::milliseconds(*whole);
}

Quality shown_quality(const Device& device, const Point& point) {
  if (device.network->down) return Quality::kNetworkDown;
  if (device.status == DeviceStatus::kUnreachable) return Quality::kDeviceOffline;
  return point.quality;
}

model::PointKey point_key(const Device& device, const Point& point) {
  return model::DeviceKey{device.key}.point(point.id.kind, point.details->id());
}

Point* find_point(Device& device, const PointId& id) {
  for (auto& point : device.points) {
    if (point.id.type == id.type && point.id.kind == id.kind && point.id.instance == id.instance) return &point;
  }
  return nullptr;
}

void fetch_points(const Device& device) {
  constexpr std::size_t kMaxFetched = 8;
  for (std::size_t i = 0; i < std::min(device.points.size(), kMaxFetched); ++i) base::prefetch(&device.points[i]);
}

Point* find_point(Device& device, PointNumber number) {
  for (auto& point : device.points) {
    if (point.number == number) return &point;
  }
  return nullptr;
}

}  // namespace rubicon::proxy
