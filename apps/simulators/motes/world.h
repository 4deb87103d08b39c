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

/// A mote, and the sink it hears at first (1, 2, ...).
struct MotePlace {
  MoteOptions mote;
  std::uint16_t sink = 1;
};

struct WorldOptions {
  std::uint16_t sinks = 1;
  SinkOptions sink;  ///< of each; number and seed are set by the world
  std::vector<MotePlace> motes;
  RadioOptions radio;
  /// All chance comes of it: the same seed and the same input give the same bytes.
  std::uint64_t seed = 1;
  /// When the first mote of each sink is switched on, and the time from one to the next. Those that are switched on
  /// together disturb each other's joins (wsn.md 9.2), and a sink may take 113 ms until it has the island's id.
  Duration first_boot = std::chrono::milliseconds(200);
  Duration boot_spacing = std::chrono::milliseconds(250);
  /// The first boot counts from when a computer has come to the sink for the first time.
  bool wait_for_computer = false;

  /// `count` motes at a sink with addresses from `first`, all like `like`.
  void add_motes(std::uint16_t at_sink, std::uint16_t first, std::uint16_t count, const MoteOptions& like = {});
};

/// Sinks, their ports, motes and the air between them, and what a script does to them.
class World {
 public:
  /// The scheduler must outlive it. The sinks of motes must exist: asserted. Steps about what does not exist do
  /// nothing: check_script() finds them.
  World(WorldOptions options, Scheduler& scheduler, std::vector<Step> script = {}, EventLog::Call events = {});
  ~World();
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  /// Makes a sink's line reachable: `world.open(1, on_memory(net.tcp, {"127.0.0.1", 19202}))`.
  Result<void> open(std::uint16_t sink, SinkPort::Opener opener);

  std::uint16_t sinks() const { return static_cast<std::uint16_t>(places_.size()); }
  SinkFirmware& sink(std::uint16_t number) { return *places_.at(number - 1U)->sink; }
  SinkPort& port(std::uint16_t number) { return *places_.at(number - 1U)->port; }
  /// The first with this address, or the one that began at a sink; asserted.
  MoteFirmware& mote(std::uint16_t address, std::uint16_t began_at = 0);
  std::vector<MoteFirmware*> motes(MotePattern pattern);
  Radio& radio() { return radio_; }

  /// Does it now, whatever its `at` says.
  void take(const Step& step);
  /// The port is gone, and the sink has no power until it is plugged in.
  void unplug(std::uint16_t sink, Duration span);

 private:
  struct Place {
    std::unique_ptr<SinkFirmware> sink;
    std::unique_ptr<SinkPort> port;
    bool booted = false;
    SteadyTime power_comes{};
    Timer plugs_in;     ///< pending: it has no power
    Timer opens_again;  ///< pending: it has no port
  };
  struct Mote {
    std::unique_ptr<MoteFirmware> firmware;
    std::uint16_t began_at = 1;
    bool empty = false;  ///< its battery, until a step brings a new one
    Timer boots;
  };

  void make_sinks();
  void make_motes();
  void boot_motes(std::uint16_t of_sink);
  void plug_in(std::uint16_t sink);
  void open_again(std::uint16_t sink);
  std::vector<Mote*> matching(MotePattern pattern);
  void reboot(const Step& step);
  void reboot_sink(std::uint16_t sink);
  void kill(Mote& mote);
  void move(const Step& step, MoteFirmware& mote);
  void take_mote_step(const Step& step, Mote& mote);
  bool exists(std::uint16_t sink) const { return sink >= 1 && sink <= places_.size(); }

  WorldOptions options_;
  Scheduler& scheduler_;
  EventLog log_;
  Radio radio_;
  std::vector<std::unique_ptr<Place>> places_;
  std::vector<Mote> motes_;
  simulation::ScriptRun<Step> script_;
};

/// kInvalid with its line for a step about a mote or a sink that is not in this world.
Result<void> check_script(const std::vector<Step>& script, const WorldOptions& world);

}  // namespace rubicon::motes_simulator
