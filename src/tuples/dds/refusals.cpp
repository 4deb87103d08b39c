#include "tuples/dds/refusals.h"

#include <fmt/format.h>

#include <atomic>
#include <deque>
#include <mutex>
#include <set>
#include <string>

#include "base/rate_limit.h"

namespace rubicon::tuples::dds {

namespace {

constexpr Duration kMinute = std::chrono::minutes(1);
/// Refusals that may wait for the loop; more are dropped.
constexpr int kMaxOnTheWay = 16;

/// What OpenSSL says of a certificate that another authority signed.
bool is_foreign(const std::string& reason) {
  return reason.find("local issuer certificate") != reason.npos || reason.find("self-signed") != reason.npos ||
         reason.find("signature failure") != reason.npos;
}

std::string line_of(const std::string& name, const std::string& reason) {
  return fmt::format("{} was refused{}: {}", name.empty() ? "a process" : fmt::format("'{}'", name),
                     is_foreign(reason) ? ", its certificate is of another realm" : "", reason);
}

}  // namespace

struct Refusals::Shared {
  Shared(Scheduler& loop, DdsEcology::Post to, base::LogSink& sink)
      : scheduler(loop), post(std::move(to)), log(sink, "dds") {}

  void report(const std::string& name, const std::string& reason) {
    const auto now = scheduler.now();
    if (now - began >= kMinute) {
      began = now;
      lines = 0;
    }
    if (!alive || lines >= kMaxLines || !limit.allow(name, now)) return;
    log.warning(line_of(name, reason));
    if (++lines == kMaxLines) log.warning("more processes are refused: they are not named for a minute");
  }

  /// Which process it was is not always known.
  void count(const GuidPrefix& peer) {
    if (peer == GuidPrefix{}) return;
    const std::lock_guard lock(mutex);
    if (!known.insert(peer).second) return;
    ++peers;
    order.push_back(peer);
    if (order.size() <= kMaxKnown) return;
    known.erase(order.front());
    order.pop_front();
  }

  mutable std::mutex mutex;
  std::set<GuidPrefix> known;    // this and the next two: with the mutex
  std::deque<GuidPrefix> order;  // of known, the oldest first
  std::uint64_t peers = 0;
  Scheduler& scheduler;
  DdsEcology::Post post;
  Log log;
  std::atomic<int> pending{0};
  bool alive = true;  // this and the rest: on the loop's thread only
  base::RateLimit limit;
  SteadyTime began{};
  int lines = 0;
};

Refusals::Refusals(Scheduler& scheduler, DdsEcology::Post post, base::LogSink& log)
    : shared_(std::make_shared<Shared>(scheduler, std::move(post), log)) {}

Refusals::~Refusals() {
  shared_->alive = false;
}

void Refusals::take(const GuidPrefix& peer, std::string_view name, std::string_view reason) {
  shared_->count(peer);
  if (shared_->pending.fetch_add(1) >= kMaxOnTheWay) {
    --shared_->pending;
    return;
  }
  shared_->post([shared = shared_, name = std::string(name), reason = std::string(reason)] {
    --shared->pending;
    shared->report(name, reason);
  });
}

std::uint64_t Refusals::peers() const {
  const std::lock_guard lock(shared_->mutex);
  return shared_->peers;
}

}  // namespace rubicon::tuples::dds
