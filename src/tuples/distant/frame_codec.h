#pragma once

#include <optional>
#include <span>
#include <utility>

#include "tuples/distant/fields.h"
#include "tuples/link.h"

namespace rubicon::tuples::distant {

/// Sent between two processes with the same component id: the question whether the other is alive, or the answer.
struct IdentityCheck {
  bool is_answer = false;
  std::uint64_t number = 0;  ///< random number of the question; the answer repeats it
};

/// When a frame was sent, and when the last one before was that came the other way. By clocks that count since the
/// start of their hosts and go on while they sleep; whole microseconds.
struct FrameTimes {
  Duration sent{};               ///< by the clock of the sender
  std::optional<Duration> echo;  ///< what `sent` said in the last frame that the sender received from the receiver
  Duration held{};               ///< how long ago the sender received it
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

/// Receives the entries of a frame in order; views point into the frame.
class FrameReader {
 public:
  virtual ~FrameReader() = default;
  virtual void on_changes(std::span<const Change> changes) = 0;
  virtual void on_set(RemoteSet&& set) = 0;
  virtual void on_reply(Reply&& reply) = 0;
  virtual void on_identity_check(const IdentityCheck& check) = 0;
  virtual void on_times(const FrameTimes& times) = 0;
  virtual void on_subscription(SubscriptionSpec&&) {}  // these two: where frames bring subscriptions
  virtual void on_unsubscription(std::uint32_t) {}
};

/// Passes the entries of a frame from `from` to `to` to the reader. kInvalid names the offset of the first invalid
/// entry; the entries before it have been passed.
Result<void> read_frame(ByteView frame, OwnerId from, OwnerId to, FrameReader& reader);

/// Decodes the content of an Interest. kInvalid if it is malformed or has no valid pattern.
Result<SubscriptionSpec> read_subscription(ByteView content);

}  // namespace rubicon::tuples::distant
