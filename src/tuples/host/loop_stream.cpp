#include "tuples/host/loop_stream.h"

#include <unistd.h>

#include <algorithm>
#include <utility>

#include "base/lifetime.h"

namespace rubicon::tuples::host {

namespace {

class LoopStream final : public transport::LocalStream {
 public:
  static constexpr std::size_t kMaxPending = 4 * kMaxRead;

  LoopStream(Scheduler& scheduler, transport::LocalCalls calls) : scheduler_(scheduler), calls_(std::move(calls)) {
    peer_.user = ::geteuid();
    peer_.process = ::getpid();
  }

  Result<std::size_t> write(ByteView bytes) override {
    const auto done = std::min(bytes.size(), kMaxPending - pending_.size());
    pending_.insert(pending_.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(done));
    full_ |= done < bytes.size();
    if (!pending_.empty()) arrive_.request();
    return done;
  }
  std::size_t unread() const override { return pending_.size(); }
  const transport::LocalPeer& peer() const override { return peer_; }

 private:
  void arrive() {
    const auto alive = lifetime_.watch();
    const auto bytes = std::exchange(pending_, {});
    if (calls_.received) calls_.received(bytes);
    if (!alive.ended() && std::exchange(full_, false) && calls_.writable) calls_.writable();
  }

  Scheduler& scheduler_;
  transport::LocalCalls calls_;
  transport::LocalPeer peer_;
  Bytes pending_;
  bool full_ = false;
  base::OncePerTurn arrive_{scheduler_, [this] { arrive(); }};
  base::Lifetime lifetime_;
};

}  // namespace

std::unique_ptr<transport::LocalStream> make_loop_stream(Scheduler& scheduler, transport::LocalCalls calls) {
  return std::make_unique<LoopStream>(scheduler, std::move(calls));
}

}  // namespace rubicon::tuples::host
