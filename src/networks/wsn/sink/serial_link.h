#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>

#include "base/lifetime.h"
#include "motes/hdlc.h"
#include "networks/wsn/sink/send_queue.h"
#include "networks/wsn/sink/sink_notifier.h"

namespace rubicon::networks::wsn::sink {

/// What a sink's serial line asks of its user (wsn.md 2, 9.7), without the line: acks what wants an ack, and sends one
/// packet at a time, the next when the sink acknowledged it, under a new sequence number with each attempt. Belongs to
/// a Sink, which may be destroyed in any of its calls.
class SerialLink {
 public:
  struct Options {
    Bytes greeting;                                  ///< as SinkOptions
    Duration ack_timeout = std::chrono::seconds(1);  ///< wsn.md 2: at least 1 s
    unsigned attempts = 3;                           ///< of what may be repeated
    std::uint8_t first_sequence = 0;
  };
  struct Calls {
    std::function<void(ByteView)> write;     ///< to the line, from which nothing may come back in this call
    std::function<std::size_t()> unwritten;  ///< bytes that the line has not taken yet
    std::function<void()> heard;             ///< the first sound frame after begin()
    std::function<void(bool)> acknowledges;  ///< whether the sink acknowledged the last packet
    std::function<void(Error)> failed;       ///< the line is of no use: end() is called next
  };
  struct Counters {
    std::uint64_t acknowledged = 0, repeated = 0, unacknowledged = 0, unsent_acks = 0;
  };

  /// An ack to the sink is not worth more than so many bytes before it.
  static constexpr std::size_t kMostUnwritten = 1024;
  /// So many packets in a row without ack, and no sound frame between them: the sink that was heard is gone.
  static constexpr unsigned kMostUnheard = 3;

  /// Takes what it sends from `queue`.
  SerialLink(Options options, Scheduler& scheduler, SendQueue& queue, SinkNotifier& notifier, Calls calls);
  SerialLink(const SerialLink&) = delete;
  SerialLink& operator=(const SerialLink&) = delete;

  /// The line is there: greets.
  void begin();
  /// The line is gone. What was under way is sent once more on the next one, if it may be and its time allows.
  void end();
  /// Bytes from the line.
  void take(ByteView bytes);
  /// Something may wait in the queue.
  void pump();

  bool up() const { return up_; }
  void count(std::map<std::string, std::uint64_t>& into) const;

 private:
  /// The packet under way.
  struct Flight {
    Outgoing packet;
    bool greeting = false;
    bool again = false;         ///< the line was lost under it before
    bool acknowledged = false;  ///< by the ack of an earlier attempt: the last one's is waited for
    unsigned attempts = 0;      ///< on this line
    unsigned blocked = 0;       ///< times the line had not taken the last attempt
    std::uint8_t first = 0;     ///< sequence number of the first attempt
  };

  void send_ack(std::uint8_t sequence);
  bool take_frame(const motes::HdlcFrame& frame);
  bool first_sound();
  void acknowledge(std::uint8_t sequence);
  void start(Flight flight);
  void attempt();
  void waited();
  bool may_repeat() const;
  void give_up();
  void next();
  void watch_kept();
  void drop_kept();
  bool note_faults();

  Options options_;
  Scheduler& scheduler_;
  SendQueue& queue_;
  SinkNotifier& notifier_;
  Calls calls_;
  motes::HdlcReader reader_;
  motes::HdlcFaults noted_, before_;  ///< faults that were told; those before this line
  bool up_ = false, heard_ = false;
  unsigned unheard_ = 0;  ///< packets in a row that were given up, without a sound frame
  std::uint8_t sequence_;
  std::optional<Flight> flight_;
  std::optional<Flight> kept_;  ///< what a lost line interrupted
  Timer ack_, kept_expiry_;
  Counters counters_;
  base::Lifetime lifetime_;
};

}  // namespace rubicon::networks::wsn::sink
