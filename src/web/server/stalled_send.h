#pragma once

#include <cstdint>
#include <functional>
#include <utility>

#include "base/deadline.h"
#include "web/server/peer_stream.h"

namespace rubicon::web::server {

/// Notices a client that takes nothing for `patience` while something is sent to it; looks six times in that time.
class StalledSend {
 public:
  StalledSend(Scheduler& scheduler, Duration patience, std::function<void()> stalled)
      : scheduler_(scheduler),
        patience_(patience),
        stalled_(std::move(stalled)),
        deadline_(scheduler, [this] { look(); }) {}

  /// Something is sent from now on, until done().
  void begin(const PeerStream& stream) {
    stream_ = &stream;
    progress();
  }
  void done() { deadline_.clear(); }

 private:
  void progress() {
    taken_ = stream_->sent();
    since_ = scheduler_.now();
    deadline_.set(patience_ / 6);
  }

  void look() {
    if (stream_->sent() != taken_) return progress();
    if (scheduler_.now() - since_ < patience_) return deadline_.set(patience_ / 6);
    const auto call = stalled_;  // it may destroy the owner of this
    call();
  }

  Scheduler& scheduler_;
  Duration patience_;
  std::function<void()> stalled_;
  const PeerStream* stream_ = nullptr;
  std::uint64_t taken_ = 0;
  SteadyTime since_{};  ///< of the last progress
  base::Deadline deadline_;
};

}  // namespace rubicon::web::server
