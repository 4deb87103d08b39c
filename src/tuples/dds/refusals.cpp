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
/// Refusals of members, and of others, that may wait for the loop; more are dropped.
constexpr int kMaxOnTheWay = 16;

/// What OpenSSL says of a certificate or a document that another authority signed.
bool is_foreign(const std::string& reason) {
  return reason.find("local issuer certificate") != reason.npos || reason.find("self-signed") != reason.npos ||
         reason.find("signature failure") != reason.npos;
}

std::string line_of_member(const std::string& name, const std::string& reason) {
  return fmt::format("'{}' was refused{}: {}", name,
                     is_foreign(reason) ? ", its permissions are not signed by this realm" : "", reason);
}

std::string line_of_other(const std::string& name, const std::string& reason) {
  return fmt::format("{} was refused{}: {}",
                     name.empty() ? "a process" : fmt::format("a process that calls itself '{}'", name),
                     is_foreign(reason) ? ", its certificate is of another realm" : "", reason);
}

/// The lines of members, or those of others.
struct Lines {
  std::atomic<int> pending{0};
  base::RateLimit limit;  // this and the rest: on the loop's thread only
  SteadyTime began{};
  int written = 0;
};

}  // namespace

struct Refusals::Shared {
  Shared(Scheduler& loop, DdsEcology::Post to, base::LogSink& sink)
      : scheduler(loop), post(std::move(to)), log(sink, "dds") {}

  void report(bool is_member, const std::string& name, const std::string& reason) {
    auto& lines = is_member ? members : others;
    --lines.pending;
    const auto now = scheduler.now();
    if (now - lines.began >= kMinute) {
      lines.began = now;
      lines.written = 0;
    }
    if (!alive || lines.written >= kMaxLines || !lines.limit.allow(name, now)) return;
    log.warning(is_member ? line_of_member(name, reason) : line_of_other(name, reason));
    if (++lines.written == kMaxLines)
      log.warning(
          fmt::format("more {} are refused: they are not named for a minute", is_member ? "members" : "processes"));
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
  bool alive = true;  // on the loop's thread only
  Lines members, others;
};

Refusals::Refusals(Scheduler& scheduler, DdsEcology::Post post, base::LogSink& log)
    : shared_(std::make_shared<Shared>(scheduler, std::move(post), log)) {}

Refusals::~Refusals() {
  shared_->alive = false;
}

void Refusals::take(const DdsTrust::Refusal& refusal) {
  shared_->count(refusal.peer);
  const bool is_member = refusal.is_verified;
  auto& pending = (is_member ? shared_->members : shared_->others).pending;
  if (pending.fetch_add(1) >= kMaxOnTheWay) {
    --pending;
    return;
  }
  shared_->post([shared = shared_, is_member, name = std::string(refusal.name), reason = std::string(refusal.reason)] {
    shared->report(is_member, name, reason);
  });
}

std::uint64_t Refusals::peers() const {
  const std::lock_guard lock(shared_->mutex);
  return shared_->peers;
}

}  // namespace rubicon::tuples::dds
