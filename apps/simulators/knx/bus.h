#pragma once

#include <functional>
#include <map>
#include <random>
#include <vector>

#include "apps/simulators/knx/script.h"
#include "base/scheduler.h"

namespace rubicon::knx_simulator {

/// The devices of a KNX line: one for each group address of a script, at 1.1.1, 1.1.2 and so on. They keep the values
/// that are written, answer reads, report at state addresses, and send what sensors measure. Lines are attached to the
/// bus: what arrives on one goes out on the others. The scheduler must outlive it.
class Bus {
 public:
  using Telegram = networks::knx::wire::Telegram;
  using GroupAddress = networks::knx::wire::GroupAddress;
  using Send = std::function<void(const Telegram&)>;

  struct Counters {
    std::uint64_t written = 0;   ///< values that others wrote
    std::uint64_t answered = 0;  ///< reads of others
    std::uint64_t ignored = 0;   ///< telegrams of others that no device of ours took
    std::uint64_t sent = 0;      ///< telegrams of our devices
  };

  /// `seed`: of the noise.
  Bus(Scheduler& scheduler, std::vector<Group> groups, std::uint64_t seed);
  Bus(const Bus&) = delete;
  Bus& operator=(const Bus&) = delete;

  /// Sensors begin to send.
  void start();
  /// A line that telegrams leave by; its number is for received().
  std::size_t attach(Send send);
  /// A telegram that arrived on a line.
  void received(const Telegram& telegram, std::size_t line);

  /// A device writes: keeps the value and sends it.
  void write(GroupAddress group, const networks::knx::wire::Payload& value);
  /// Keeps the value without a telegram.
  void set(GroupAddress group, const networks::knx::wire::Payload& value);
  /// A device reads, as an actuator does at its start.
  void read(GroupAddress group);
  /// Writes numbers from `from` to `to` each second.
  void ramp(GroupAddress group, double from, double to, Duration span);
  /// Devices send nothing and answer nothing for so long.
  void silence(Duration span);

  /// nullptr: there is no such group address.
  const networks::knx::wire::Payload* value(GroupAddress group) const;
  const Counters& counters() const { return counters_; }

 private:
  struct Ramp {
    double from = 0, to = 0;
    SteadyTime began;
    Duration span{};
    Timer timer;
  };
  struct Device {
    Group group;
    networks::knx::wire::IndividualAddress address{};
    double base = 0;  ///< what noise is added to
    Ramp ramp;
    Timer sensor, answering, reporting;
  };

  Device* find(GroupAddress group);
  void measure(Device& device);
  double measured(const Device& device);
  void step(Device& device);
  void write_number(Device& device, double number);
  void keep(Device& device, const networks::knx::wire::Payload& value);
  void report_state(const Device& device);
  void answer(Device& device);
  void send(const Device& device, GroupAddress group, networks::knx::wire::Service service,
            const networks::knx::wire::Payload& value);

  Scheduler& scheduler_;
  std::map<GroupAddress, Device> devices_;
  std::vector<Send> lines_;
  std::mt19937_64 random_;
  SteadyTime started_{}, silent_until_{};
  Counters counters_;
};

}  // namespace rubicon::knx_simulator
