#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

#include "base/bytes.h"
#include "rubicon/address.hpp"
#include "rubicon/time.hpp"
#include "tuples/link.h"

namespace rubicon::tuples::distant {

/// Appends fields of what is sent to other components: numbers in groups of seven bits, the lowest first, each group
/// but the last with its highest bit set; signed numbers with their sign in the lowest bit; texts after their size.
class FieldWriter {
 public:
  void byte(std::uint8_t value) { bytes_.push_back(value); }
  void number(std::uint64_t value) { value < 0x80 ? byte(static_cast<std::uint8_t>(value)) : long_number(value); }
  void signed_number(std::int64_t value);
  void text(std::string_view text);
  void bytes(ByteView bytes) { bytes_.insert(bytes_.end(), bytes.begin(), bytes.end()); }

  std::size_t size() const { return bytes_.size(); }
  ByteView view() const { return bytes_; }
  Bytes take() { return std::exchange(bytes_, {}); }
  void clear() { bytes_.clear(); }

 private:
  void long_number(std::uint64_t value);

  Bytes bytes_;
};

/// Reads what FieldWriter wrote. After an invalid read all further ones give zero, ok() is false and at_end() true.
class FieldReader {
 public:
  explicit FieldReader(ByteView bytes) : bytes_(bytes) {}

  std::uint8_t byte() { return at_ < bytes_.size() ? bytes_[at_++] : fail_read(); }
  std::uint64_t number() { return at_ < bytes_.size() && bytes_[at_] < 0x80 ? bytes_[at_++] : long_number(); }
  std::int64_t signed_number();
  std::string_view text();
  /// All that follows.
  ByteView rest();
  WallTime time() { return WallTime(std::chrono::microseconds(signed_number())); }
  /// Clamped to 0..100 years.
  Duration duration();
  OwnerId owner();

  bool ok() const { return ok_; }
  bool at_end() const { return at_ == bytes_.size(); }
  std::size_t position() const { return at_; }
  /// The read was invalid, for a reason that the caller knows.
  std::uint8_t fail_read();

 private:
  std::uint64_t long_number();

  ByteView bytes_;
  std::size_t at_ = 0;
  bool ok_ = true;
};

/// Sent between two processes with the same component id: the question whether the other is alive, or the answer.
struct IdentityCheck {
  bool is_answer = false;
  std::uint64_t number = 0;  ///< random number of the question; the answer repeats it
};

/// When a frame was sent, and what its sender knows of the last frame that it received from the receiver. Whole
/// microseconds, by clocks that count from the start of their host and go on while it sleeps.
struct FrameTimes {
  Duration sent{};               ///< by the clock of the sender
  std::optional<Duration> echo;  ///< `sent` of that last frame, by the clock of the receiver
  Duration held{};               ///< how long before `sent` the sender received it
  bool asks = false;             ///< the receiver should send its times at once
};

/// Encodes what one component sends to another as entries of a frame (docs/ecology.md).
class FrameWriter {
 public:
  void add(const Change& change);
  void add(const RemoteSet& set) { add(set, set.time_to_live); }
  /// With that time to live in place of its own.
  void add(const RemoteSet& set, Duration time_to_live);
  void add(const Reply& reply);
  void add(const IdentityCheck& check);
  /// As the first entry: it holds for all that follow.
  void add(const FrameTimes& times);
  /// The content of an Interest, not of a frame.
  void add(const SubscriptionSpec& spec);
  /// The same as an entry, where frames bring subscriptions.
  void add_subscription(const SubscriptionSpec& spec);
  void add_unsubscription(std::uint32_t id);
  /// Entries that are encoded already.
  void add(ByteView entries) { fields_.bytes(entries); }

  std::size_t size() const { return fields_.size(); }
  ByteView view() const { return fields_.view(); }
  Bytes take() { return fields_.take(); }
  void clear() { fields_.clear(); }

 private:
  void set_entry(const TupleView& tuple);

  FieldWriter fields_;
};

/// Receives the entries of a frame in order; views point into the frame. Entries whose function is not overridden are
/// skipped.
class FrameReader {
 public:
  virtual ~FrameReader() = default;
  virtual void on_changes(std::span<const Change>) {}
  virtual void on_set(RemoteSet&&) {}
  virtual void on_reply(Reply&&) {}
  virtual void on_identity_check(const IdentityCheck&) {}
  virtual void on_times(const FrameTimes&) {}
  virtual void on_subscription(SubscriptionSpec&&) {}
  virtual void on_unsubscription(std::uint32_t) {}
};

/// Passes the entries of a frame from `from` to `to` to the reader. kInvalid names the offset of the first invalid
/// entry; the entries before it have been passed.
Result<void> read_frame(ByteView frame, OwnerId from, OwnerId to, FrameReader& reader);

/// Decodes the content of an Interest. kInvalid if it is malformed or has no valid pattern.
Result<SubscriptionSpec> read_subscription(ByteView content);

/// How old the frames of one peer are. No clocks are compared. A frame of the peer repeats `sent` of a frame of this
/// side
/// (`echo`) and says how long the peer held that (`held`): so the peer sent it at echo + held or later, by the own
/// clock. `now` counts from the start of the own host, also while it slept.
class FrameAges {
 public:
  /// For a frame to the peer.
  FrameTimes next(Duration now, bool asks) const;
  /// A frame of the peer was received.
  void arrived(const FrameTimes& times, Duration now);
  /// The age of a frame of the peer that said `sent`. It is never less than the true age, and exceeds that at most by
  /// the time that an earlier exchange took and kMaxSlack. nullopt: the peer has to be asked. Either nothing is known,
  /// or that exchange took so long that it is open whether the true age is less than `lives`.
  std::optional<Duration> age(Duration sent, Duration now, Duration lives) const;

  /// Clocks of two hosts may drift apart by this part of the time.
  static constexpr int kDriftParts = 2000;
  static constexpr Duration kMaxSlack = std::chrono::milliseconds(50);

 private:
  struct Heard {
    Duration sent, at;
  };
  /// The own time is ahead of the peer's by this at least, as an echo of that own time showed.
  struct Lead {
    Duration least, at;
    Duration exchange;  ///< what the echo spent on its ways: it is ahead by that much more at most
  };
  static Duration slack(const Lead& lead, Duration now) { return (now - lead.at) / kDriftParts; }

  std::optional<Heard> heard_;
  std::optional<Lead> lead_;
};

}  // namespace rubicon::tuples::distant
