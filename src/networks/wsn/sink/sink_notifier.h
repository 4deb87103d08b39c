#pragma once

#include "base/lifetime.h"
#include "networks/wsn/sink/sink.h"

namespace rubicon::networks::wsn::sink {

/// Holds the state of a Sink and calls its callbacks. Each of these may destroy the sink, and with it this object:
/// methods that return false were the last thing to happen in it, and their caller must return at once.
class SinkNotifier {
 public:
  explicit SinkNotifier(SinkCallbacks callbacks) : callbacks_(std::move(callbacks)) {}
  SinkNotifier(const SinkNotifier&) = delete;
  SinkNotifier& operator=(const SinkNotifier&) = delete;

  /// For open(): sets the phase without a callback.
  void connecting() { state_ = {SinkState::Phase::kConnecting, {}}; }
  bool set_state(SinkState::Phase phase, std::string reason);
  /// The line is lost: phase kOff with this reason.
  bool failed(Error why);
  /// A packet from the sink. Packets whose dispatch byte is not 00 (serial AM) are counted and discarded (wsn.md 2,
  /// rule 6).
  bool received(ByteView packet);
  /// A packet was sent for the first time.
  bool sent(ByteView packet);
  bool note(const std::string& subject, std::string_view text);
  void room(Lane lane) const;

  const SinkState& state() const { return state_; }
  /// Adds the counters `packets-read`, `packets-written` and `unknown-dispatches`.
  void count(std::map<std::string, std::uint64_t>& into) const;

 private:
  SinkCallbacks callbacks_;
  SinkState state_;
  std::uint64_t read_ = 0, written_ = 0, unknown_dispatches_ = 0;
  base::Lifetime lifetime_;
};

}  // namespace rubicon::networks::wsn::sink
