#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "base/text.h"
#include "zigbee/real_rig.h"
#include "zigbee/records.h"

namespace rubicon::bench::zigbee {

namespace {

using namespace std::chrono_literals;

constexpr std::uintmax_t kHuge = 268'000'000;

/// How long the loop was not free for others: beyond a millisecond after each millisecond.
class Gaps {
 public:
  explicit Gaps(Scheduler& scheduler) : scheduler_(scheduler) { tick(); }
  double longest_ms() const { return rounded(longest_, 1); }
  void forget() { longest_ = 0; }

 private:
  void tick() {
    const auto began = Clock::now();
    next_ = scheduler_.after(1ms, [this, began] {
      longest_ = std::max(longest_, milliseconds(Clock::now() - began) - 1);
      tick();
    });
  }

  Scheduler& scheduler_;
  double longest_ = 0;
  Timer next_;
};

/// A file with blocks on the disk only where the text is.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& text, std::uintmax_t size)
      : path_(std::filesystem::temp_directory_path() / ("rubicon-bench-" + std::to_string(::getpid()))) {
    std::ofstream(path_) << text;
    std::filesystem::resize_file(path_, size);
  }
  ~TemporaryFile() { std::filesystem::remove(path_); }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  std::string path() const { return path_.string(); }

 private:
  std::filesystem::path path_;
};

/// While nothing comes: what the machine and the other programs on it do to any loop.
double quiet(RealRig& rig, Gaps& gaps) {
  gaps.forget();
  rig.run(5s);
  return gaps.longest_ms();
}

/// A client of version 3.1.1 gets a packet beyond its bound.
double huge_packet(RealRig& rig, Gaps& gaps) {
  const TemporaryFile file("", kHuge);
  bool dropped = false;
  transport::MqttOptions options;
  options.version = transport::MqttVersion::k311;
  const auto line = rig.connect([](const transport::MqttMessage&) {}, options,
                                [&dropped](std::string_view, std::size_t) { dropped = true; });
  must(line->subscribe("huge"));
  rig.run(100ms);
  support::Process publisher(
      {"mosquitto_pub", "-h", "127.0.0.1", "-p", std::to_string(kPort), "-t", "huge", "-f", file.path()});
  gaps.forget();
  rig.run_until([&] { return dropped; }, "the huge packet does not come");
  return gaps.longest_ms();
}

/// How many devices the island lists; costs it nothing.
std::size_t listed(island::Island& island) {
  const auto count = island.space().get(kIsland, "proxy.zigbee.property.devices.value");
  return count ? base::parse_number<std::size_t>(count->value).value_or(0) : 0;
}

/// An island gets a list; then once more, with one more device.
Json list_of_all(RealRig& rig, Gaps& gaps, int count) {
  const auto bridge = rig.connect([](const transport::MqttMessage&) {});
  const auto records = device_records(count);
  publish_bridge(*bridge, list_of(records, 0));
  const auto island = start_island(rig.scheduler(), rig.transports(), rig.ecology());
  rig.run_until([&] { return line_of(*island) == "up"; }, "the line does not come up");
  const auto publish = [&](const std::vector<std::string>& all, std::size_t devices, const char* what) {
    const auto list = list_of(all, devices);
    const TemporaryFile file(list, list.size());
    support::Process publisher({"mosquitto_pub", "-h", "127.0.0.1", "-p", std::to_string(kPort), "-t",
                                "zigbee2mqtt/bridge/devices", "-f", file.path()});
    gaps.forget();
    rig.run_until([&] { return listed(*island) == devices; }, what);
    rig.run(1s);
    return gaps.longest_ms();
  };
  const auto joins = publish(records, records.size() - 1, "the devices do not join");
  return {{"devices", records.size()},
          {"all_join_ms", joins},
          {"one_joins_ms", publish(records, records.size(), "the last device does not join")}};
}

}  // namespace

/// Longest gaps of a loop that has an MQTT line, in milliseconds.
void measure_gaps(const Plan& plan, Json& out) {
  RealRig rig(out, "gaps");
  if (!rig) return;
  Gaps gaps(rig.scheduler());
  out["gaps"] = {{"quiet_ms", quiet(rig, gaps)}, {"huge_packet_ms", huge_packet(rig, gaps)}};
  out["gaps"]["list"] = list_of_all(rig, gaps, plan.devices);
  out["gaps"]["longest_list"] = list_of_all(rig, gaps, plan.devices_of_longest_list);
}

}  // namespace rubicon::bench::zigbee
