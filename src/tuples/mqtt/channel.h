#pragma once

#include <deque>
#include <functional>
#include <variant>

#include "base/scheduler.h"
#include "tuples/distant/frame_codec.h"
#include "tuples/mqtt/messages.h"

namespace rubicon::tuples::mqtt {

/// Bytes of memory that it takes while it waits: about the size of its entry.
inline std::size_t size_of(const RemoteSet& set) {
  return sizeof(RemoteSet) + 64 + set.key.size() + set.value.size() + set.media_type.size();
}

/// Everything between one own component and one other, in order and without loss, over a broker that drops what it
/// likes and says nothing: frames have numbers, are kept until the other side acknowledges them, and sent again from
/// the first that is missing. The other side says how many may be under way. Without I/O: frames leave by a call.
class Channel {
 public:
  struct Ends {
    OwnerId self{}, peer{};
    std::uint64_t self_incarnation = 0, peer_incarnation = 0;
  };
  /// kLater: flush() tries again. kTooLarge: never.
  enum class Sent : std::uint8_t { kYes, kLater, kTooLarge };
  struct Losses {
    std::uint64_t again = 0;  ///< frames that were sent again
    std::uint64_t gaps = 0;   ///< missing frames of others; frames that follow each other count once
  };
  struct Callbacks {
    std::function<Sent(const FrameHead& head, ByteView entries)> send;
    /// These are given up: no frame can carry them.
    std::function<void(ByteView entries)> too_large;
    /// Whether the broker may drop a frame of that size each time, without a word.
    std::function<bool(std::size_t size)> may_swallow;
    /// The entries of a frame, in the order of frames, each once. May destroy the channel.
    std::function<void(ByteView entries)> received;
    /// The other side met this one again, and knows nothing of what went before.
    std::function<void()> met_again;
    /// How many frames the other side may have under way.
    std::function<std::uint32_t()> credit;
    std::function<Duration()> since_boot;
    Losses* losses = nullptr;  ///< of all channels of a process, must outlive them; null: not counted
  };
  /// `stream`: higher than the number of each earlier channel between the two.
  Channel(Scheduler& scheduler, const Ends& ends, std::uint64_t stream, Callbacks calls);

  /// Entries encoded by a FrameWriter.
  void add(Bytes entries);
  /// The rest of its time to live is computed when it is sent.
  void add(RemoteSet set);
  /// Sends the times with the next frame, which may have nothing else. `asks`: for those of the other side.
  void add_times(bool asks);
  /// Sends what may be sent. To be called at the end of a turn, so that its changes leave together.
  void flush();
  /// A frame of the other side.
  void arrived(const FrameHead& head, ByteView entries);
  /// The connection of this or of the other side was lost and is back: frames without an acknowledgement are sent
  /// again.
  void reconnected();
  /// The broker refused that frame for its size.
  void too_large(std::uint64_t stream, std::uint64_t number);

  /// Bytes that wait until they may be sent.
  std::size_t waiting() const { return waiting_; }
  /// Since when the other side owes an acknowledgement; nullopt: it owes none.
  std::optional<SteadyTime> unanswered_since() const;
  distant::FrameAges& ages() { return ages_; }

  static constexpr std::size_t kFrameBytes = std::size_t{32} * 1024;
  /// Bytes that may be sent and not acknowledged: what the other side acknowledged in a second, within these bounds.
  static constexpr std::size_t kMinUnderWay = std::size_t{512} << 10, kMaxUnderWay = std::size_t{8} << 20;
  static constexpr std::uint32_t kFirstCredit = 4, kMaxCredit = 256;

 private:
  struct TimedSet {
    RemoteSet set;
    SteadyTime since;
  };
  using Entry = std::variant<Bytes, TimedSet>;
  struct Kept {
    std::uint64_t number = 0;
    Bytes entries;
    SteadyTime since;      ///< it was sent first
    unsigned sent = 0;     ///< how often
    bool missing = false;  ///< the other side has a later one
  };

  void push(Entry entry, std::size_t size);
  Bytes next_entries();
  bool may_send() const;
  bool send(Kept& frame);
  bool is_swallowed(const Kept& frame) const;
  void give_up(Kept& frame);
  void answer(bool again = false);
  bool send_kept(std::uint64_t from);
  void forget_up_to(std::uint64_t number);
  void acknowledged(const FrameHead& head);
  void note_pace();
  bool is_next(const FrameHead& head);
  void take(const FrameHead& head);
  void send_again();
  FrameHead head() const;

  Scheduler& scheduler_;
  Ends ends_;
  Callbacks callbacks_;
  // what is sent
  std::uint64_t stream_, next_ = 1, acknowledged_ = 0;
  std::uint64_t unsent_ = 1;  ///< the first number that was never sent
  std::deque<Kept> kept_;     ///< sent and not acknowledged
  std::deque<std::pair<Entry, std::size_t>> entries_;
  std::size_t waiting_ = 0, kept_bytes_ = 0, most_under_way_ = kMinUnderWay;
  std::size_t taken_bytes_ = 0;  ///< acknowledged since then
  SteadyTime taken_since_{};
  std::uint32_t credit_ = kFirstCredit;
  bool times_due_ = false, asks_ = false;
  SteadyTime oldest_since_{}, again_at_{};
  Duration repeat_pause_;
  // what is received
  std::uint64_t heard_stream_ = 0, heard_ = 0;
  unsigned unanswered_ = 0;  ///< frames since the last acknowledgement
  bool gap_told_ = false;
  distant::FrameAges ages_;
  base::Deadline answer_later_, repeat_;
};

}  // namespace rubicon::tuples::mqtt
