#pragma once

#include <optional>

#include "tuples/distant/frame_codec.h"

namespace rubicon::tuples::distant {

/// How old the frames of one peer are. No clocks are compared: a frame repeats a time that this side sent and says how
/// long the peer held it, so it was not sent before. All times: since the start of the own host, also while it slept.
class FrameAges {
 public:
  /// For a frame to the peer.
  FrameTimes next(Duration now, bool asks) const;
  /// A frame of the peer was received.
  void arrived(const FrameTimes& times, Duration now);
  /// The age of a frame of the peer that said `sent`: never less than the true one, and more by at most the time that
  /// an earlier exchange took, and kMaxSlack. nullopt: the peer has to be asked.
  std::optional<Duration> age(Duration sent, Duration now) const;

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
  };
  static Duration slack(const Lead& lead, Duration now) { return (now - lead.at) / kDriftParts; }

  std::optional<Heard> heard_;
  std::optional<Lead> lead_;
};

}  // namespace rubicon::tuples::distant
