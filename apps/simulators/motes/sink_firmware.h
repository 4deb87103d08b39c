#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <random>

#include "apps/simulators/motes/event.h"
#include "apps/simulators/motes/message_memory.h"
#include "apps/simulators/motes/mockup.h"
#include "apps/simulators/motes/radio.h"
#include "apps/simulators/motes/serial_output.h"
#include "apps/simulators/motes/serial_receiver.h"

namespace rubicon::motes_simulator {

/// When the serial acknowledgement of a frame begins to leave, counted from its last byte (wsn.md 2: 46 to 67 ms, once
/// 113 ms). Never before the frame's own command is done with.
struct AckDelay {
  Duration shortest = std::chrono::milliseconds(46);
  Duration longest = std::chrono::milliseconds(67);
  Duration odd = std::chrono::milliseconds(113);
  double odd_share = 0.02;
};

struct SinkOptions {
  std::uint16_t number = 1;   ///< which sink of the world: the cell of its radio, and its name in events
  std::uint16_t island = 11;  ///< compiled in; what it has again after each reboot (wsn.md 6, 9.1)
  unsigned baud = 115200;     ///< 0 = the line takes no time
  AckDelay ack;
  /// A command is in the works for as long as the line took for so many frames like it, but at most 40 ms: of ten back
  /// to back four are executed, of four at once two, as measured (wsn.md 9.7, 10). 0 = it takes no time.
  double processing = 3.7;
  /// Replies to joins are for all who hear them, so that each mote that has not joined answers with garbage (wsn.md
  /// 9.2): of many that boot at once hardly one joins then. Else they are for the one address alone.
  bool reply_to_all = false;
  bool readings = false;  ///< beyond the recordings: it has sensors and reports as device 1 when told to
  double stale = 0.25;    ///< MessageMemory
  std::uint64_t seed = 1;
};

/// A sink with the released firmware: what goes on between its serial line and its radio (wsn.md 9, 10), oddities
/// included. Runs from the beginning; radio, scheduler and log outlive it.
class SinkFirmware final : public RadioNode {
 public:
  /// Frames that came faster than the line is, until they are held up: congested() says so.
  static constexpr std::size_t kBacklog = 64;
  static constexpr std::size_t kMaxBacklog = 4096;
  /// And so much time that bytes of any kind, sound frames or not, will take on the line.
  static constexpr Duration kLineAhead = std::chrono::milliseconds(100);
  /// Packets as the computer knows them, for a recorder: to it, or (`written`) from it.
  using Watch = std::function<void(bool written, ByteView packet)>;

  SinkFirmware(SinkOptions options, Radio& radio, Scheduler& scheduler, const EventLog& log);
  SinkFirmware(const SinkFirmware&) = delete;
  SinkFirmware& operator=(const SinkFirmware&) = delete;

  /// Bytes that the computer sent, in pieces of any size; they take their time on the line.
  void received(ByteView bytes);
  /// Where its bytes go; empty = nobody reads, and they are lost.
  void connect(SerialOutput::Out out) { output_.connect(std::move(out)); }
  void watch(Watch watch) { watch_ = std::move(watch); }
  bool congested() const { return arriving_.size() > kBacklog || line_free_ > scheduler_.now() + kLineAhead; }
  /// Called when it is no longer.
  void on_room(std::function<void()> room) { room_ = std::move(room); }
  /// The computer is gone: what it sent and is not on the line yet never comes. What has come of a frame stays, as the
  /// sink knows nothing of it.
  void hung_up();

  /// Off and on: it is on its compiled island again, and tells nobody.
  void reboot();
  /// Power is gone until reboot().
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
    Duration works{};           ///< how long it keeps a buffer
    SteadyTime acknowledged{};  ///< executed after that, as in all recordings
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
  void tell_room();
  void arrived();
  void take(Arriving arrived);
  SteadyTime acknowledge(std::uint8_t sequence, Duration worked);
  void await_acks();
  void await_work();
  void worked();
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
  void tell(std::string_view what, std::uint16_t mote = 0, const motes::NetMessage* message = nullptr) const;

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
  std::optional<Joining> joining_;  ///< it remembers one only (wsn.md 9.2)
  std::size_t frame_length_ = 0;
  SteadyTime line_free_{}, work_free_{}, executed_{};
  std::deque<Arriving> arriving_;
  std::deque<Ack> acks_;
  std::deque<Arriving> work_;   ///< `at`: when its buffer is free again
  std::deque<Arriving> ready_;  ///< `at`: when it is executed
  Timer line_timer_, arrival_timer_, ack_timer_, work_timer_, execution_timer_;
};

}  // namespace rubicon::motes_simulator
