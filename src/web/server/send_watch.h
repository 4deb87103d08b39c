#pragma once

#include <cstdint>
#include <functional>
#include <utility>

#include "base/deadline.h"
#include "web/server/peer_stream.h"

namespace rubicon::web::server {

/// Notices a client that takes nothing while something is sent to it.
class SendWatch {
 public:
  SendWatch(Scheduler& scheduler, Duration patience, std::function<void()> stalled)
      : patience_(patience), stalled_(std::move(stalled)), deadline_(scheduler, [this] { look(); }) {}

  /// Something is sent from now on, until done().
  void begin(const PeerStream& stream) {
    stream_ = &stream;
    taken_ = stream.sent();
    deadline_.set(patience_);
  }
  void done() { deadline_.clear(); }

 private:
  void look() {
    if (stream_->sent() != taken_) return begin(*stream_);
    const auto call = stalled_;  // it may destroy the owner of this
    call();
  }

  Duration patience_;
  std::function<void()> stalled_;
  const PeerStream* stream_ = nullptr;
  std::uint64_t taken_ = 0;
  base::Deadline deadline_;
};

}  // namespace rubicon::web::server
