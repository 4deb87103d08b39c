#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string_view>

#include "base/bytes.h"
#include "base/scheduler.h"
#include "rubicon/address.hpp"
#include "rubicon/result.hpp"
#include "transport/sockets.h"

namespace rubicon::tuples::host {

/// What one process sends to another. Each record has a type and the same fields; those that its type does not name are
/// zero or empty.
struct Record {
  enum class Type : std::uint8_t {
    kHello = 1,   ///< the first: number = version of the protocol, text = token of the sender
    kUp,          ///< component id of the sender is there: number = incarnation, text = host, content = summary
    kDown,        ///< it left
    kSummary,     ///< content = its summary
    kInterest,    ///< it subscribes: content as FrameWriter::add(SubscriptionSpec)
    kNoInterest,  ///< no longer: number = id of the subscription
    kFrame,       ///< to component target: number = its incarnation, content = entries of FrameWriter. Times to live in
                  ///< it are ends, by Folder::since_boot()
    kReady,       ///< all components were told
    kAsk,         ///< does the receiver live? It answers at once
    kAnswer,
    kGoodbye  ///< the sender ends: its components leave
  };

  Type type = Type::kHello;
  OwnerId id{}, target{};
  std::uint64_t number = 0;
  std::string_view text{};  ///< at most kMaxText bytes
  ByteView content{};

  static constexpr std::size_t kMaxText = 64;
};

inline constexpr std::uint64_t kProtocolVersion = 1;
/// Longest record: the largest value with its key and texts.
inline constexpr std::size_t kMaxRecord = (std::size_t{1024} + 64) * 1024;
/// Bytes of the size before each record, lowest first.
inline constexpr std::size_t kSizeBytes = 4;

/// Appends the record with its size.
void append(Bytes& out, const Record& record);
/// Writes the size of the record that these bytes are.
void put_size(std::span<std::uint8_t> record);
/// Reads one record without its size; the views are into it. kInvalid names its type.
Result<Record> read_record(ByteView bytes);
/// 16 hexadecimal digits in lower case.
bool is_token(std::string_view text);

/// Records over a byte stream, in order. What is sent in one turn of the loop is written together, and frames to one
/// component become one.
class Connection {
 public:
  struct Callbacks {
    std::function<void(const Record& record)> record;  ///< valid during the call
    /// The stream ended, or brought what is not a record. Called once; the connection is closed then.
    std::function<void(const Error& why)> ended;
  };

  explicit Connection(Scheduler& scheduler) : scheduler_(scheduler) {}
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  /// To be called once, before the stream is made: its calls. The stream is given next, by take().
  transport::LocalCallbacks begin(Callbacks calls);
  void take(std::unique_ptr<transport::LocalStream> stream);
  /// Replaces the stream: sent records come back in a later turn.
  void loop(Callbacks calls);

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
  /// From now on has_read() knows whether the other process reads.
  void watch_reading();
  /// Whether it has read since the last call, or since watch_reading().
  bool has_read();
  bool is_open() const { return stream_ != nullptr; }
  /// Of a connection that has a stream and is not closed.
  const transport::LocalPeer& peer() const { return stream_->peer(); }
  /// No calls follow, and waiting records are not sent.
  void close();

 private:
  bool lengthen_last(const Record& record);
  Result<std::size_t> write(ByteView bytes);
  void look_at_unread();
  void received(ByteView bytes);
  std::size_t pass_records(ByteView bytes);
  void end(const Error& why);

  Scheduler& scheduler_;
  Callbacks callbacks_;
  std::unique_ptr<transport::LocalStream> stream_;
  Bytes partial_;  ///< the beginning of a record whose rest has not arrived
  Bytes out_;      ///< of this turn
  /// The last record in out_, and its position there.
  Record last_{};
  std::size_t last_at_ = 0;
  Bytes queue_;  ///< from written_ on; what the system did not take
  std::size_t written_ = 0;
  std::optional<std::size_t> unread_;  ///< what the system held after the last write; none: it is not watched
  bool has_read_ = false;
  bool closed_ = false, loops_ = false, held_ = false;
  base::OncePerTurn flush_soon_{scheduler_, [this] { flush(); }};
  base::Lifetime lifetime_;
};

}  // namespace rubicon::tuples::host
