#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>

#include "base/scheduler.h"
#include "motes/framing.h"
#include "networks/wsn/sink/send_queue.h"
#include "networks/wsn/sink/sink.h"

namespace rubicon::networks::wsn::sink {

/// The computer's side of a sink's serial protocol (wsn.md 2, 9.7), without the line itself: acknowledges the frames
/// that ask for it, and sends one packet at a time: the next one after the sink's acknowledgement, each attempt under a
/// new sequence number. Owned by a Sink, which may be destroyed in any callback.
class SerialLink {
 public:
  struct Options {
    Bytes greeting;                                  ///< SinkOptions::greeting
    Duration ack_timeout = std::chrono::seconds(1);  ///< wsn.md 2: at least 1 s
    unsigned attempts = 3;                           ///< for repeatable packets, 1 to 100
    std::uint8_t first_sequence = 0;
  };
  struct Callbacks {
    std::function<void(ByteView)> write;     ///< to the line, which must not call back during this call
    std::function<std::size_t()> unwritten;  ///< bytes that the line has not taken yet
    std::function<void()> heard;             ///< the first valid frame after begin()
    std::function<void(bool)> acknowledges;  ///< whether the sink acknowledged the last packet
    std::function<void(Error)> failed;       ///< the line is unusable: the owner calls end() next
  };
  struct Counters {
    std::uint64_t acknowledged = 0, repeated = 0, unacknowledged = 0, unsent_acks = 0;
  };

  /// With more unwritten bytes than this, acknowledgements to the sink are not sent.
  static constexpr std::size_t kMaxUnwritten = 1024;
  /// A sink that was heard is lost after this many unacknowledged packets in a row without a valid frame between them.
  static constexpr unsigned kMaxUnanswered = 3;

  /// Takes the packets to send from `queue`. All references must outlive it.
  SerialLink(Options options, Scheduler& scheduler, SendQueue& queue, SinkNotifier& notifier, Callbacks callbacks);
  SerialLink(const SerialLink&) = delete;
  SerialLink& operator=(const SerialLink&) = delete;

  /// The line is up: sends the greeting. Asserts that it was down.
  void begin();
  /// The line is lost. The packet under way is sent again on the next line if it is repeatable and has not expired.
  void end();
  /// Bytes from the line.
  void take(ByteView bytes);
  /// The queue may hold a packet.
  void pump();

  bool up() const { return up_; }
  void count(std::map<std::string, std::uint64_t>& into) const;

 private:
  /// The packet under way.
  struct Flight {
    Outgoing packet;
    bool greeting = false;
    bool interrupted = false;   ///< an earlier line was lost while it was under way
    bool acknowledged = false;  ///< on an earlier attempt, while the acknowledgement of the last one is outstanding
    unsigned attempts = 0;      ///< on this line
    unsigned blocked = 0;       ///< timeouts during which the line did not take the last attempt
    std::uint8_t first = 0;     ///< sequence number of the first attempt
  };

  void send_ack(std::uint8_t sequence);
  bool take_frame(const motes::HdlcFrame& frame);
  bool note_first_frame();
  void acknowledge(std::uint8_t sequence);
  void start(Flight flight);
  void attempt();
  void ack_timed_out();
  bool may_repeat() const;
  void give_up();
  void next();
  void expire_interrupted();
  void drop_interrupted();
  bool note_faults();

  Options options_;
  Scheduler& scheduler_;
  SendQueue& queue_;
  SinkNotifier& notifier_;
  Callbacks callbacks_;
  motes::HdlcReader reader_;
  motes::HdlcFaults noted_;    ///< faults already passed to the notifier
  motes::HdlcFaults earlier_;  ///< faults on earlier lines
  bool up_ = false, heard_ = false;
  unsigned unanswered_ = 0;  ///< unacknowledged packets since the last valid frame
  std::uint8_t sequence_;
  std::optional<Flight> flight_;
  std::optional<Flight> interrupted_;  ///< by the loss of the line
  Timer ack_timeout_, interrupted_expiry_;
  Counters counters_;
  base::Lifetime lifetime_;
};

}  // namespace rubicon::networks::wsn::sink
