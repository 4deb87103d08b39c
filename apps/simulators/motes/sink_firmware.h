#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <random>

#include "apps/simulators/motes/event.h"
#include "apps/simulators/motes/mockup.h"
#include "apps/simulators/motes/radio.h"
#include "apps/simulators/motes/serial_line.h"

namespace rubicon::motes_simulator {

/// From the last byte of a frame to the start of its serial acknowledgement (wsn.md 2: 46 to 67 ms, once 113 ms). The
/// acknowledgement is never sent before the frame was processed.
struct AckDelay {
  Duration shortest = std::chrono::milliseconds(46);
  Duration longest = std::chrono::milliseconds(67);
  Duration outlier = std::chrono::milliseconds(113);
  double outlier_share = 0.02;
};

struct SinkOptions {
  std::uint16_t number = 1;   ///< in the world: the cell of its radio, and its name in events
  std::uint16_t island = 11;  ///< compiled in; set again by each reboot (wsn.md 6, 9.1)
  unsigned baud = 115200;     ///< 0: the line takes no time
  AckDelay ack;
  /// Processing time of a command, in multiples of its time on the line, at most 40 ms. As measured, four of ten
  /// commands back to back are executed, and two of four at once (wsn.md 9.7, 10). 0: none.
  double processing = 3.7;
  /// Broadcasts the replies to joins, so that each mote that has not joined answers with garbage (wsn.md 9.2): of many
  /// that boot together hardly one joins. Otherwise replies go to one address.
  bool reply_to_all = false;
  bool readings = false;  ///< extension: it has sensors and reports as device 1 on command
  double stale = 0.25;    ///< MessageMemory
  std::uint64_t seed = 1;
};

/// A sink with the released firmware, between its serial line and its radio (wsn.md 9, 10), including its bugs. On from
/// the start. Radio, scheduler and log must outlive it.
class SinkFirmware final : public RadioNode {
 public:
  /// Frames that may arrive faster than the line transmits before congested() is true.
  static constexpr std::size_t kBacklog = 64;
  static constexpr std::size_t kMaxBacklog = 4096;
  /// Line time of all bytes, valid frames or not, before congested() is true.
  static constexpr Duration kLineAhead = std::chrono::milliseconds(100);
  /// Packets for a recorder: to the computer, or (`written`) from it.
  using Watch = std::function<void(bool written, ByteView packet)>;

  SinkFirmware(SinkOptions options, Radio& radio, Scheduler& scheduler, const EventLog& log);
  SinkFirmware(const SinkFirmware&) = delete;
  SinkFirmware& operator=(const SinkFirmware&) = delete;

  /// Bytes from the computer, in pieces of any size; they take their time on the line.
  void received(ByteView bytes);
  /// Receives its bytes; empty: they are lost.
  void connect(SerialOutput::Out out) { output_.connect(std::move(out)); }
  void watch(Watch watch) { watch_ = std::move(watch); }
  bool congested() const { return arriving_.size() > kBacklog || line_free_ > scheduler_.now() + kLineAhead; }
  /// Called when congested() becomes false.
  void on_room(std::function<void()> room) { room_ = std::move(room); }
  /// The computer disconnected: bytes that are not on the line yet are lost. The part of a frame that arrived stays,
  /// because the sink does not notice.
  void disconnected();

  /// Off and on: it has its compiled-in island id again, and does not report it.
  void reboot();
  /// Switches it off until reboot().
  void kill();
  std::uint16_t island() const { return island_; }
  std::uint16_t number() const { return options_.number; }

  bool hear(const AirMessage& message) override;

 private:
  static constexpr std::size_t kSerialIn = 2;
  struct Arriving {
    SerialFrame frame;
    SteadyTime at{};
    std::size_t length = 0;     ///< on the line
    Duration processing{};      ///< how long it occupies a buffer
    SteadyTime acknowledged{};  ///< executed after this, as in all recordings
  };
  struct Ack {
    SteadyTime at{};
    std::uint8_t sequence = 0;
  };
  struct Joining {
    std::uint16_t mote = 0, sequence = 0;
  };

  void await_frames();
  void await_line();
  void notify_room();
  void arrived();
  void take(Arriving arrived);
  SteadyTime acknowledge(std::uint8_t sequence, Duration processing);
  void await_acks();
  void await_processing();
  void processed();
  void await_execution();
  void execute(const Bytes& packet);
  void on_config(ByteView payload);
  void on_serial_message(ByteView payload);
  void on_own_message(const motes::NetMessage& message);
  void acknowledge_message(const motes::NetMessage& message);
  void send_own(Peer to, std::uint8_t application, ByteView record);
  void route_own(Peer to, Bytes payload);
  void forward(std::uint16_t mote, ByteView payload, std::uint8_t counted);
  void on_join_request(const AirMessage& request);
  void on_ack_join(ByteView payload);
  void on_air_message(ByteView payload);
  void to_serial(ByteView payload);
  void log_event(std::string_view what, std::uint16_t mote = 0, const motes::NetMessage* message = nullptr) const;

  SinkOptions options_;
  Scheduler& scheduler_;
  const EventLog& log_;
  Transmitter transmitter_;
  Radio::Node node_;
  SerialReceiver receiver_;
  SerialOutput output_;
  Sensors sensors_;
  MessageMemory memory_;
  Mockup mockup_;
  std::mt19937_64 rng_;
  Watch watch_;
  std::function<void()> room_;
  bool on_ = true;
  std::uint16_t island_;
  std::optional<Joining> joining_;  ///< it remembers only one (wsn.md 9.2)
  std::size_t frame_length_ = 0;
  SteadyTime line_free_{}, processor_free_{}, executed_{};
  std::deque<Arriving> arriving_;
  std::deque<Ack> acks_;
  std::deque<Arriving> processing_;  ///< `at`: when its buffer becomes free
  std::deque<Arriving> ready_;       ///< `at`: when it is executed
  Timer line_timer_, arrival_timer_, ack_timer_, processing_timer_, execution_timer_;
};

}  // namespace rubicon::motes_simulator
