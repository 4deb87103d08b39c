#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "apps/simulators/motes/event.h"
#include "apps/simulators/motes/mockup.h"
#include "apps/simulators/motes/radio.h"
#include "apps/simulators/motes/sensors.h"

namespace rubicon::motes_simulator {

/// The transducers that a build declares, and those the board really has (wsn.md 6).
struct BoardBuild {
  std::uint16_t declared = 0x00b0;
  std::uint16_t real = 0x00b0;
};
/// `STANDARD` (declares 6f52), `EM1000`, `SE1000`, or a mask in four hex digits.
std::optional<BoardBuild> parse_build(std::string_view name);

struct MoteOptions {
  std::uint16_t address = 2;
  std::uint8_t type = 1;  ///< every board declares 1, and 01 as its actuators (wsn.md 6)
  std::uint8_t actuators = 1;
  BoardBuild board;
  bool obey = false;                                      ///< MockupOptions
  bool updates = false;                                   ///< MockupOptions
  Duration sensor_time = std::chrono::milliseconds(210);  ///< MockupOptions
  double stale = 0.25;                                    ///< MessageMemory
  std::uint64_t seed = 1;
};

/// A mote with the released firmware (wsn.md 8, 9), above its radio. Off until boot(). Radio, scheduler and log must
/// outlive it.
class MoteFirmware final : public RadioNode {
 public:
  static constexpr unsigned kJoinRequests = 7;

  MoteFirmware(MoteOptions options, Radio::Cells hears, Radio& radio, Scheduler& scheduler, const EventLog& log);
  MoteFirmware(const MoteFirmware&) = delete;
  MoteFirmware& operator=(const MoteFirmware&) = delete;

  /// Switches it on, or off and on: its memory is cleared, and its random numbers start again.
  void boot();
  /// Switches it off.
  void kill();
  void move_to(Radio::Cells cells) { radio_.place(node_, std::move(cells)); }
  /// The transmit queue stalls with the next message (wsn.md 14, 38), until boot().
  void stall() { transmitter_.stall(); }

  bool on() const { return on_; }
  /// In its own view; the sink may not have reported it to the computer (wsn.md 9.2).
  bool joined() const { return joined_; }
  std::uint16_t address() const { return options_.address; }
  std::uint16_t island() const { return island_; }
  Radio::Node node() const { return node_; }
  Sensors& sensors() { return sensors_; }

  bool hear(const AirMessage& message) override;

 private:
  void request_join();
  void on_join_reply(ByteView payload);
  void acknowledge_join(std::uint16_t sequence);
  void on_net(ByteView payload);
  void on_message(const motes::NetMessage& message);
  void acknowledge(const motes::NetMessage& message);
  void send(Peer to, std::uint8_t application, ByteView record);
  void transmit(Peer to, Bytes payload);
  void log_event(std::string_view what, const motes::NetMessage* message = nullptr) const;

  MoteOptions options_;
  Radio& radio_;
  Scheduler& scheduler_;
  const EventLog& log_;
  Radio::Node node_;
  Transmitter transmitter_;
  Sensors sensors_;
  MessageMemory memory_;
  Mockup mockup_;
  bool on_ = false, joined_ = false, replied_ = false;
  std::uint16_t island_ = 0, join_sequence_ = 0;
  unsigned requests_ = 0;
  std::uint64_t boot_count_ = 0;
  Timer join_timer_;
};

}  // namespace rubicon::motes_simulator
