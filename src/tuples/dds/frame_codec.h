#pragma once

#include <span>
#include <utility>

#include "base/bytes.h"
#include "tuples/link.h"

namespace rubicon::tuples::dds {

/// Between two processes with one component id: the question whether the other is alive, and its answer.
struct IdentityCheck {
  bool is_answer = false;
  std::uint64_t number = 0;  ///< drawn by who asks; the answer repeats it
};

/// What one component tells another, put behind each other into frames (docs/ecology.md).
class FrameWriter {
 public:
  void add(const Change& change);
  void add(const RemoteSet& wish);
  void add(const Reply& reply);
  void add(const IdentityCheck& check);
  /// The content of an Interest, not of a frame.
  void add(const SubscriptionSpec& spec);
  void add(ByteView entries);

  std::size_t size() const { return bytes_.size(); }
  ByteView view() const { return bytes_; }
  Bytes take() { return std::exchange(bytes_, {}); }
  void clear() { bytes_.clear(); }

 private:
  void byte(std::uint8_t value) { bytes_.push_back(value); }
  void number(std::uint64_t value);
  void signed_number(std::int64_t value);
  void text(std::string_view text);

  Bytes bytes_;
};

/// Who takes the entries of a frame, in their order; views are into the frame.
class FrameReader {
 public:
  virtual ~FrameReader() = default;
  virtual void on_changes(std::span<const Change> changes) = 0;
  virtual void on_set(RemoteSet&& wish) = 0;
  virtual void on_reply(Reply&& reply) = 0;
  virtual void on_identity_check(const IdentityCheck& check) = 0;
};

/// Tells the entries of a frame from `from` to `to`. kInvalid names the offset of the first unsound one; what stood
/// before it was told.
Result<void> read_frame(ByteView frame, OwnerId from, OwnerId to, FrameReader& reader);

/// The content of an Interest. kInvalid: not that, or its pattern is none.
Result<SubscriptionSpec> read_subscription(ByteView content);

}  // namespace rubicon::tuples::dds
