#pragma once

#include <memory>
#include <vector>

#include "apps/simulators/motes/event.h"
#include "apps/simulators/motes/mote_firmware.h"
#include "apps/simulators/motes/radio.h"
#include "apps/simulators/motes/script.h"
#include "apps/simulators/motes/sink_firmware.h"
#include "apps/simulators/motes/sink_port.h"
#include "apps/simulators/script.h"

namespace rubicon::motes_simulator {

/// A mote, and the sink that it hears at the start (1, 2, ...).
struct MotePlace {
  MoteOptions mote;
  std::uint16_t sink = 1;
};

struct WorldOptions {
  std::uint16_t sinks = 1;
  SinkOptions sink;  ///< of each sink; the world sets number and seed
  std::vector<MotePlace> motes;
  RadioOptions radio;
  /// Of all random numbers: the same seed and the same input give the same bytes.
  std::uint64_t seed = 1;
  /// When the first mote of each sink is switched on, and the time from one mote to the next. Motes that are switched
  /// on together disturb each other's joins (wsn.md 9.2), and a sink may need 113 ms to take the island's id.
  Duration first_boot = std::chrono::milliseconds(200);
  Duration boot_spacing = std::chrono::milliseconds(250);
  /// first_boot counts from the first connection of a computer to the sink.
  bool wait_for_computer = false;

  /// Adds `count` copies of `like` at a sink, with addresses from `first`.
  void add_motes(std::uint16_t at_sink, std::uint16_t first, std::uint16_t count, const MoteOptions& like = {});
};

/// Sinks with their ports, motes, the radio between them, and a script that acts on them.
class World {
 public:
  /// The scheduler must outlive it. Asserts that the sinks of all motes exist. Steps for motes and sinks that do not
  /// exist have no effect; check_script() finds them.
  World(WorldOptions options, Scheduler& scheduler, std::vector<Step> script = {}, EventLog::Callback events = {});
  ~World();
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  /// Makes a sink's line reachable: `world.open(1, on_tcp(transports, {"127.0.0.1", 19202}))`.
  Result<void> open(std::uint16_t sink, SinkPort::Opener opener);

  std::uint16_t sinks() const { return static_cast<std::uint16_t>(places_.size()); }
  SinkFirmware& sink(std::uint16_t number) { return *places_.at(number - 1U)->sink; }
  SinkPort& port(std::uint16_t number) { return *places_.at(number - 1U)->port; }
  /// The first mote with this address, or the one that started at a sink. Asserts that it exists.
  MoteFirmware& mote(std::uint16_t address, std::uint16_t began_at = 0);
  std::vector<MoteFirmware*> motes(MotePattern pattern);
  Radio& radio() { return radio_; }

  /// Executes a step now, whatever its `at`.
  void execute(const Step& step);
  /// Closes the port and switches the sink off, for `span`.
  void unplug(std::uint16_t sink, Duration span);

 private:
  struct Place {
    std::unique_ptr<SinkFirmware> sink;
    std::unique_ptr<SinkPort> port;
    bool booted = false;
    SteadyTime power_on{};
    Timer plug_in;  ///< pending: the sink is off
    Timer reopen;   ///< pending: the port is closed
  };
  struct Mote {
    std::unique_ptr<MoteFirmware> firmware;
    std::uint16_t began_at = 1;
    bool killed = false;  ///< until it is rebooted
    Timer boot;
  };

  void make_sinks();
  void make_motes();
  void boot_motes(std::uint16_t of_sink);
  void plug_in(std::uint16_t sink);
  void reopen(std::uint16_t sink);
  std::vector<Mote*> matching(MotePattern pattern);
  void reboot(const Step& step);
  void reboot_sink(std::uint16_t sink);
  void kill(Mote& mote);
  void move(const Step& step, MoteFirmware& mote);
  void execute_for(const Step& step, Mote& mote);
  bool exists(std::uint16_t sink) const { return sink >= 1 && sink <= places_.size(); }

  WorldOptions options_;
  Scheduler& scheduler_;
  EventLog log_;
  Radio radio_;
  std::vector<std::unique_ptr<Place>> places_;
  std::vector<Mote> motes_;
  simulation::ScriptRun<Step> script_;
};

/// kInvalid, with the line, if a step names a mote or a sink that this world does not have.
Result<void> check_script(const std::vector<Step>& script, const WorldOptions& world);

}  // namespace rubicon::motes_simulator
