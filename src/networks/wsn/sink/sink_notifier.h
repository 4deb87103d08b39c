#pragma once

#include "base/lifetime.h"
#include "networks/wsn/sink/sink.h"

namespace rubicon::networks::wsn::sink {

/// What a sink tells, and its state. Belongs to a Sink, which may be destroyed in any of these calls: whoever makes one
/// touches nothing more when it gives false.
class SinkNotifier {
 public:
  explicit SinkNotifier(SinkCallbacks calls) : calls_(std::move(calls)) {}
  SinkNotifier(const SinkNotifier&) = delete;
  SinkNotifier& operator=(const SinkNotifier&) = delete;

  /// From inside open(): tells nobody.
  void connecting() { state_ = {SinkState::Phase::kConnecting, {}}; }
  bool state(SinkState::Phase phase, std::string reason);
  /// The line is lost: kOff with this reason.
  bool failed(Error why);
  /// A packet from the sink. What does not begin with 00, the dispatch byte of serial AM, is dropped and counted
  /// (wsn.md 2, rule 6).
  bool received(ByteView packet);
  /// A packet left for the first time.
  bool left(ByteView packet);
  bool note(const std::string& subject, std::string_view text);
  void room(Lane lane) const;

  const SinkState& state() const { return state_; }
  void count(std::map<std::string, std::uint64_t>& into) const;

 private:
  SinkCallbacks calls_;
  SinkState state_;
  std::uint64_t read_ = 0, written_ = 0, other_dispatch_ = 0;
  base::Lifetime lifetime_;
};

}  // namespace rubicon::networks::wsn::sink
