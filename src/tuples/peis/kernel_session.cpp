#include "tuples/peis/kernel_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "tuples/peis/translation.h"

namespace rubicon::tuples::peis {

namespace {

constexpr std::array<std::string_view, 12> kKeys{"kernel.id",        "kernel.name",        "kernel.hostname",
                                                 "kernel.user",      "kernel.version",     kQuitKey,
                                                 "kernel.all-keys",  "kernel.subscribers", "kernel.traffic",
                                                 "kernel.step-time", "kernel.connections", "kernel.routingtable"};

struct Rates {
  std::uint64_t in = 0, out = 0;
};

Rates rates_of(const LinkState& link, const std::vector<LinkState>& before, Duration span) {
  const auto same = std::find_if(before.begin(), before.end(), [&](const LinkState& other) {
    return other.peer == link.peer && other.remote == link.remote;
  });
  const auto seconds = std::max(1e-3, std::chrono::duration<double>(span).count());
  const auto rate = [&](std::uint64_t now, std::uint64_t then) {
    return static_cast<std::uint64_t>(static_cast<double>(now - std::min(now, then)) / seconds);
  };
  const bool known = same != before.end();
  return {rate(link.bytes_in, known ? same->bytes_in : 0), rate(link.bytes_out, known ? same->bytes_out : 0)};
}

}  // namespace

bool KernelTuples::owns(std::string_view key) {
  return std::find(kKeys.begin(), kKeys.end(), folded(key)) != kKeys.end();
}

bool KernelTuples::set(std::string_view key, std::string value, WallTime now) {
  const auto found = tuples_.find(key);
  if (found == tuples_.end()) {
    tuples_[std::string(key)] = {std::move(value), 0, now};
    return true;
  }
  auto& tuple = found->second;
  if (tuple.value == value) return false;
  tuple = {std::move(value), tuple.number + 1, now};
  return true;
}

Bytes write_kernel_tuple(OwnerId self, std::string_view key, const KernelTuples::Tuple& tuple) {
  const auto data = tuple.value + '\0';
  NetworkTuple out;
  out.owner = out.creator = self;
  out.key = key;
  out.write_time = tuple.written;
  out.user_time = out.expire_time = WallTime{};
  out.encoding = Encoding::kAscii;
  out.media_type = media_type_on_wire({});
  out.data = data;
  out.sequence = tuple.number;
  return write_push(out);
}

std::string connections_text(const std::vector<LinkState>& links, const std::vector<LinkState>& before, Duration span) {
  std::string text = "(";
  for (const auto& link : links) {
    const auto rates = rates_of(link, before, span);
    text += fmt::format("({} {} {} tcp 0)", number(link.peer), rates.in, rates.out);
  }
  return text + ")";
}

std::string traffic_text(const std::vector<LinkState>& links, const std::vector<LinkState>& before, Duration span) {
  Rates sum;
  for (const auto& link : links) {
    const auto rates = rates_of(link, before, span);
    sum.in += rates.in;
    sum.out += rates.out;
  }
  return fmt::format("({} {})", sum.in, sum.out);
}

std::string routing_text(const std::vector<RouteState>& routes) {
  std::string text = "(\n";
  for (const auto& route : routes)
    text += fmt::format(" ({} {} {})\n", number(route.to), route.metric, number(route.via));
  return text + ")\n";
}

KernelSession::KernelSession(SessionContext& context, OwnerId peer, View& view)
    : Session(context, peer),
      view_(view),
      again_(context.scheduler, [this] { during([this] { request_again(); }); }),
      expiry_(context.scheduler, [this] { expire_copies(); }),
      refusals_due_(context.scheduler, [this] { tell_more_refusals(); }) {}

void KernelSession::receive(Port port, ByteView body) {
  switch (port) {
    case Port::kPush: return on_push(body);
    case Port::kPushAppended: return on_appended(body);
    case Port::kSubscribe: return on_subscribe(body);
    case Port::kUnsubscribe: return on_unsubscribe(body);
    case Port::kSetRemote: return on_set(body);
    case Port::kSetAppend: return on_append(body);
    default: return;  // of components of ours that did not say hello
  }
}

Done KernelSession::guarded(std::function<void(Outcome)> call) {
  return lifetime_.guard([this, call = std::move(call)](Outcome outcome) { during([&] { call(outcome); }); });
}

/// Its tuples count again whatever their numbers; it has none of our subscriptions, and gets our tuples again.
void KernelSession::forgotten() {
  copies_.begin_round();
  requests_.clear();
  due_requests_.clear();
  lost_deletes_.clear();
  for (auto& [id, subscription] : subscriptions_) subscription.waits = true;
  for (const auto id : subscribers_.begin_again()) join(id);
  deliver(Restart{});
}

void KernelSession::back() {
  request_again();
}

std::vector<std::string> KernelSession::patterns() const {
  std::vector<std::string> all;
  for (const auto& [name, entry] : subscribers_.entries()) all.push_back(entry.pattern);
  return all;
}

void KernelSession::ended() {
  for (const auto& set : std::exchange(sets_, {})) answer(set.request, Outcome::kHostGone, 0);
}

}  // namespace rubicon::tuples::peis
