#include "bridges/ros2/diagnostics.h"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <utility>

#include "base/text.h"
#include "bridges/ros2/messages.h"
#include "bridges/ros2/names.h"
#include "ros_types.h"

namespace rubicon::bridges::ros2 {

namespace {

constexpr Duration kChangePause = std::chrono::milliseconds(100);

/// A part of a text, in whole characters.
std::string cut(std::string_view text) {
  const auto kept = text.substr(0, Diagnostics::kMaxValue);
  return kept.size() == text.size() ? std::string(text) : fmt::format("{}...", kept.substr(0, base::utf8_prefix(kept)));
}

/// Messages with the texts that they point to: written when they are full, and at the end.
class Report {
 public:
  /// Of one status: they fill half of a message.
  static constexpr std::size_t kMaxValues = Diagnostics::kMaxMessage / 2 / (2 * Diagnostics::kMaxValue);

  Report(dds_entity_t writer, WallTime now) : writer_(writer), now_(now) {}
  Report(const Report&) = delete;
  Report& operator=(const Report&) = delete;
  ~Report() { write(); }

  void status(Level level, std::string name, std::string message, std::string hardware,
              const std::vector<std::pair<std::string, std::string>>& values) {
    std::size_t size = name.size() + message.size() + hardware.size() + 2 * kRoom;
    for (const auto& [key, value] : values) size += key.size() + value.size() + kRoom;
    if (size_ + size > Diagnostics::kMaxMessage) write();
    size_ += size;
    auto& made = all_.emplace_back();
    made.level = static_cast<std::uint8_t>(level);
    made.name = keep(std::move(name));
    made.message = keep(std::move(message));
    made.hardware_id = keep(std::move(hardware));
    auto& kept = values_.emplace_back();
    for (const auto& [key, value] : values) kept.push_back({keep(key), keep(value)});
    lend(made.values, kept);
  }

 private:
  /// In CDR: lengths, ends and padding of two texts.
  static constexpr std::size_t kRoom = 16;

  char* keep(std::string text) { return texts_.emplace_back(std::move(text)).data(); }
  void write() {
    if (all_.empty()) return;
    diagnostic_msgs_msg_dds__DiagnosticArray_ message{};
    const auto us = now_.time_since_epoch().count();
    message.header.stamp = {static_cast<std::int32_t>(us / 1'000'000),
                            static_cast<std::uint32_t>(us % 1'000'000 * 1000)};
    message.header.frame_id = keep({});
    lend(message.status, all_);
    dds_write(writer_, &message);
    texts_.clear();
    all_.clear();
    values_.clear();
    size_ = 0;
  }

  dds_entity_t writer_;
  WallTime now_;
  std::size_t size_ = 0;
  std::deque<std::string> texts_;  // their addresses stay
  std::vector<diagnostic_msgs_msg_dds__DiagnosticStatus_> all_;
  std::deque<std::vector<diagnostic_msgs_msg_dds__KeyValue_>> values_;
};

std::string shown_value(const PointEntry& point) {
  const bool has_unit = point.about && point.about->unit != "1";
  return fmt::format("{} ({})", cut(point.value + (has_unit ? " " + point.about->unit : "")), to_string(point.quality));
}

constexpr const char* kAway = "its island is not there";

void add_device(Report& report, const DeviceEntry& device, bool island_is_away, std::string name) {
  auto level = device.is_away() ? Level::kError : island_is_away ? Level::kWarn : Level::kOk;
  std::string message = device.status.empty() ? "unknown" : device.status;
  if (device.lost || island_is_away) message = kAway;
  std::vector<std::pair<std::string, std::string>> values;
  for (const auto* point : device.points) {
    if (values.size() < Report::kMaxValues) values.emplace_back(point->id(), shown_value(*point));
    const auto its = point->is_event() ? Level::kOk : level_of(point->quality);
    if (worse(level, its) == level) continue;
    level = its;
    message = fmt::format("{}: {}", point->id(), to_string(point->quality));
  }
  if (device.points.size() > values.size())
    values.emplace_back("more points", fmt::to_string(device.points.size() - values.size()));
  report.status(level, std::move(name), cut(message), cut(device.about ? device.about->address : ""), values);
}

}  // namespace

Level level_of(model::Quality quality) {
  switch (quality) {
    case Quality::kGood:
    case Quality::kAssumed: return Level::kOk;
    case Quality::kStored:
    case Quality::kUnknown: return Level::kWarn;
    case Quality::kStale: return Level::kStale;
    case Quality::kBad:
    case Quality::kDeviceOffline:
    case Quality::kNetworkDown: break;
  }
  return Level::kError;
}

Level worse(Level one, Level other) {
  const auto rank = [](Level level) {
    return level == Level::kStale ? 3 : level == Level::kError ? 4 : static_cast<int>(level);
  };
  return rank(one) >= rank(other) ? one : other;
}

Diagnostics::Diagnostics(const BridgeHost& host, const Options& options, House& house)
    : host_(host), options_(options), house_(house), soon_(host.scheduler, kChangePause, [this] { say_changes(); }) {}

void Diagnostics::attach(Node* node) {
  writer_.reset();
  read_ = false;
  tick_.cancel();
  if (node == nullptr || options_.diagnostics == Duration(0)) return;
  if (auto made = node->writer("/diagnostics", Form::kDiagnosticArray, Keep::kReadings)) writer_ = std::move(*made);
}

void Diagnostics::news(dds_entity_t endpoint) {
  if (!writer_ || endpoint != writer_.get()) return;
  const bool was = std::exchange(read_, matched_readers(writer_.get()) > 0);
  if (read_ && !was) tick();
  if (!read_) tick_.cancel();
}

void Diagnostics::changed(const DeviceEntry& device) {
  if (!read_) return;
  changed_.insert(&device);
  soon_.request();
}

void Diagnostics::networks_changed() {
  networks_changed_ = true;
  if (read_) soon_.request();
}

void Diagnostics::island_changed(const IslandEntry& island) {
  house_.each_device([&](const DeviceEntry& device) {
    if (device.island == island.id) changed(device);
  });
}

void Diagnostics::tick() {
  house_.each_device([this](const DeviceEntry& device) { changed_.insert(&device); });
  networks_changed_ = true;
  soon_.call_now();
  tick_ = host_.scheduler.after(options_.diagnostics, [this] { tick(); });
}

void Diagnostics::say_changes() {
  if (!read_) return;
  Report report(writer_.get(), host_.scheduler.wall_now());
  if (std::exchange(networks_changed_, false)) {
    house_.each_network([&](const NetworkEntry& network) {
      report.status(network.works ? Level::kOk : Level::kError,
                    place_of(house_.find_island(network.island), network.island, token(network.id)),
                    network.lost    ? kAway
                    : network.works ? "up"
                                    : "down",
                    {}, {});
    });
  }
  for (const auto* device : std::exchange(changed_, {})) {
    const auto* island = house_.find_island(device->island);
    add_device(report, *device, island != nullptr && !island->present,
               place_of(island, device->island, token(device->network) + "/" + token(device->id)));
  }
}

std::string Diagnostics::place_of(const IslandEntry* island, OwnerId id, const std::string& below) {
  const bool is_named = island != nullptr && !island->name.empty();
  return fmt::format("rubicon: {}/{}", is_named ? token(island->name) : fmt::to_string(number(id)), below);
}

}  // namespace rubicon::bridges::ros2
