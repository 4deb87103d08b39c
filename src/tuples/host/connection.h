#pragma once

#include <functional>

#include "base/lifetime.h"
#include "base/scheduler.h"
#include "transport/local_stream.h"
#include "tuples/host/records.h"

namespace rubicon::tuples::host {

/// Records over a byte stream, in order. What is sent in one turn of the loop is written together, and frames to one
/// component become one.
class Connection {
 public:
  struct Calls {
    std::function<void(const Record& record)> record;  ///< valid during the call
    /// The stream ended, or brought what is no record. Called once; the connection is closed then.
    std::function<void(const Error& why)> ended;
  };

  explicit Connection(Scheduler& scheduler) : scheduler_(scheduler) {}
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  /// To be called once, before the stream is made: its calls. The stream is given next, by take().
  transport::LocalCalls begin(Calls calls);
  void take(std::unique_ptr<transport::LocalStream> stream);
  /// In place of a stream: what is sent comes back, in a later turn.
  void loop(Calls calls);

  /// Passes no more records until release(). More than kMaxHeld bytes end the connection.
  void hold() { held_ = true; }
  bool is_held() const { return held_; }
  void release();
  static constexpr std::size_t kMaxHeld = std::size_t{4} << 20;
  /// A connection whose other process reads nothing ends when more bytes wait.
  static constexpr std::size_t kMaxWaiting = std::size_t{48} << 20;
  /// Bytes of the content to which a frame grows.
  static constexpr std::size_t kFrameBytes = std::size_t{16} * 1024;

  /// Written at the end of the turn, with all others of it.
  void send(const Record& record);
  /// Writes now what the system takes.
  void flush();
  /// Bytes that wait here.
  std::size_t waiting() const { return queue_.size() - written_ + out_.size(); }
  /// Bytes that the other process has not read, those that wait here too.
  std::size_t unread() const { return waiting() + (stream_ ? stream_->unread() : 0); }
  bool is_open() const { return stream_ != nullptr; }
  /// Of a connection that has a stream and is not closed.
  const transport::LocalPeer& peer() const { return stream_->peer(); }
  /// No calls follow, and nothing that waits is sent.
  void close();

 private:
  bool lengthen_last(const Record& record);
  void received(ByteView bytes);
  std::size_t pass_records(ByteView bytes);
  void end(const Error& why);

  Scheduler& scheduler_;
  Calls calls_;
  std::unique_ptr<transport::LocalStream> stream_;
  Bytes partial_;  ///< the beginning of a record whose rest has not arrived
  Bytes out_;      ///< of this turn
  /// What out_ ends with, and where it begins there.
  Record last_{};
  std::size_t last_at_ = 0;
  Bytes queue_;  ///< from written_ on; what the system did not take
  std::size_t written_ = 0;
  bool closed_ = false, loops_ = false, held_ = false;
  base::OncePerTurn flush_soon_{scheduler_, [this] { flush(); }};
  base::Lifetime lifetime_;
};

}  // namespace rubicon::tuples::host
