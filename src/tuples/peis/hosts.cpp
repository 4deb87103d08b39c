#include "tuples/peis/hosts.h"

#include <algorithm>
#include <utility>

namespace rubicon::tuples::peis {

using namespace std::chrono_literals;

Hosts::Hosts(Scheduler& scheduler, NodeCounters& counters, Callbacks calls)
    : scheduler_(scheduler), counters_(counters), callbacks_(std::move(calls)), next_(scheduler, [this] { sweep(); }) {}

/// Null: too many hosts.
Hosts::Host* Hosts::obtain(OwnerId id, bool is_neighbour) {
  const auto now = scheduler_.now();
  if (const auto found = hosts_.find(id); found != hosts_.end()) return &found->second;
  const auto limit = kMaxHosts + (is_neighbour ? kReserved : 0);
  if (hosts_.size() >= limit) {
    std::erase_if(hosts_, [&](const auto& item) {
      const auto& host = item.second;
      return host.state == State::kAbsent && !host.routable && (is_neighbour || !host.counted_lost);
    });
  }
  if (hosts_.size() >= limit) {
    ++counters_.too_many_hosts;
    return nullptr;
  }
  auto& host = hosts_[id];
  host.identity.id = id;
  host.heard = now;
  due(now + kForgetTime);
  return &host;
}

bool Hosts::learn(const HostRecord& record, RecordSource source) {
  if (is_over(record.id, record.magic) && !takes_back(record, source)) return false;
  auto* host = obtain(record.id, source == RecordSource::kOwnLink);
  if (!host) return false;
  host->heard = scheduler_.now();
  if (source == RecordSource::kAnnounced) return hear(*host, record);
  const auto magic = host->identity.magic;
  if (magic != 0 && record.magic != magic) {
    const bool present = host->routable || host->state != State::kAbsent;
    if (source == RecordSource::kOther && (present || host->informed)) return true;
    restart(*host, record.magic, source != RecordSource::kOther);
  }
  if (source == RecordSource::kOther && host->informed) return true;
  take(*host, record);
  host->is_sure = source != RecordSource::kOther;
  host->claim.reset();
  evaluate(*host);
  return true;
}

/// A start that another one took the id from lives on if it connects after that one is gone.
bool Hosts::takes_back(const HostRecord& record, RecordSource source) {
  auto& host = hosts_.at(record.id);
  if (source != RecordSource::kOwnLink || host.state != State::kAbsent || host.routable) return false;
  for (auto& former : host.former) {
    if (former.magic == record.magic) former = {};
  }
  return true;
}

bool Hosts::hear(Host& host, const HostRecord& record) {
  const bool is_other = host.identity.magic != 0 && record.magic != host.identity.magic;
  const bool is_present = host.routable || host.state != State::kAbsent;
  if (host.is_sure || (is_other && is_present)) {
    if (record.magic != host.record.magic || record.addresses != host.record.addresses) host.claim = record;
    return true;
  }
  if (is_other) restart(host, record.magic, false);
  take(host, record);
  evaluate(host);
  return true;
}

void Hosts::take(Host& host, const HostRecord& record) {
  host.record = record;
  host.informed = true;
  host.query_due = SteadyTime::max();
  host.identity.magic = record.magic;
  host.identity.host_name = record.host_name;
  host.identity.full_name = record.full_name;
}

/// Another start of the host. If that is sure, the one before is over.
void Hosts::restart(Host& host, std::uint32_t magic, bool is_sure) {
  const bool was_up = become_absent(host);
  const auto before = host.identity;
  if (is_sure) host.former[host.next_former++ % host.former.size()] = {before.magic, scheduler_.now() + kForgetTime};
  host.identity = {before.id, magic, {}, {}, std::nullopt};
  host.informed = host.is_sure = host.counted_lost = false;
  host.hello_way = {};
  host.queries = 0;
  host.left_until = {};
  if (was_up) callbacks_.event(HostEvent::kLost, before);
}

bool Hosts::may_be_hello(OwnerId id, const Hello& hello, HelloWay way) const {
  const auto found = hosts_.find(id);
  if (found == hosts_.end()) return true;
  const auto& present = found->second.identity.hello;
  return !present || *present == hello || way > found->second.hello_way;
}

void Hosts::hello(OwnerId id, const Hello& hello, HelloWay way) {
  const auto found = hosts_.find(id);
  if (found == hosts_.end()) return;
  auto& host = found->second;
  const bool is_news = host.identity.hello != hello;
  host.identity.hello = hello;
  host.hello_way = std::max(host.hello_way, way);
  if (host.state == State::kGreeting) return become_up(host);
  if (host.state == State::kUp && is_news) callbacks_.event(HostEvent::kHello, Identity(host.identity));
}

void Hosts::routable(OwnerId id, std::uint32_t magic, bool is_sure) {
  auto* host = obtain(id);
  if (!host) return;
  if (host->identity.magic != 0 && host->identity.magic != magic) restart(*host, magic, is_sure);
  host->identity.magic = magic;
  if (const auto& claim = host->claim; !host->informed && claim && claim->magic == magic) take(*host, *claim);
  host->routable = true;
  host->heard = scheduler_.now();
  evaluate(*host);
}

void Hosts::evaluate(Host& host) {
  const auto now = scheduler_.now();
  if (!host.routable) return;
  if (!host.informed) {
    if (host.query_due == SteadyTime::max()) ask(host, now);
    return;
  }
  if (now < host.left_until) return due(host.left_until);
  if (host.state == State::kMissing) {
    host.state = State::kUp;
    return callbacks_.event(HostEvent::kBack, Identity(host.identity));
  }
  if (host.state != State::kAbsent) return;
  host.state = State::kGreeting;
  host.due = now + kHelloWait;
  due(host.due);
  callbacks_.greet(host.identity.id);
  if (std::exchange(host.counted_lost, false)) return callbacks_.returned(Identity(host.identity));
  if (host.identity.hello) become_up(host);
}

void Hosts::become_up(Host& host) {
  host.state = State::kUp;
  callbacks_.event(HostEvent::kUp, Identity(host.identity));
}

/// Whether it was up.
bool Hosts::become_absent(Host& host) {
  const auto before = std::exchange(host.state, State::kAbsent);
  if (before != State::kAbsent) callbacks_.gone(host.identity.id);
  return before == State::kUp || before == State::kMissing;
}

void Hosts::unroutable(OwnerId id, SteadyTime heard) {
  const auto found = hosts_.find(id);
  if (found == hosts_.end() || !std::exchange(found->second.routable, false)) return;
  auto& host = found->second;
  const auto now = scheduler_.now();
  host.query_due = SteadyTime::max();
  host.queries = 0;
  host.heard = now;
  if (host.state == State::kGreeting) become_absent(host);
  if (host.state != State::kUp) return;
  host.state = State::kMissing;
  host.due = host.identity.hello ? std::max(now, heard + host.identity.hello->lease) : now + kKernelLease;
  due(host.due);
}

void Hosts::lose(Host& host) {
  become_absent(host);
  host.counted_lost = true;
  callbacks_.event(HostEvent::kLost, Identity(host.identity));
}

void Hosts::left(OwnerId id) {
  const auto found = hosts_.find(id);
  if (found == hosts_.end()) return;
  auto& host = found->second;
  const bool was_up = become_absent(host);
  host.routable = host.counted_lost = false;
  host.query_due = SteadyTime::max();
  host.left_until = scheduler_.now() + kLeaveTime;
  if (was_up) callbacks_.event(HostEvent::kLeft, Identity(host.identity));
}

bool Hosts::message(OwnerId id) {
  const auto found = hosts_.find(id);
  if (found == hosts_.end()) return false;
  if (found->second.state == State::kGreeting) become_up(found->second);
  return found->second.state == State::kUp || found->second.state == State::kMissing;
}

void Hosts::ask(Host& host, SteadyTime now) {
  host.query_due = now + std::min<Duration>(500ms * (1 << std::min(host.queries, 5)), kRoutingPeriod);
  ++host.queries;
  due(host.query_due);
  callbacks_.query(host.identity.id);
}

void Hosts::sweep() {
  const auto now = scheduler_.now();
  std::vector<OwnerId> ids;
  for (const auto& [id, host] : hosts_) ids.push_back(id);
  for (const auto id : ids) {  // events may change the table
    const auto found = hosts_.find(id);
    if (found != hosts_.end()) sweep(found->second, now);
  }
  std::erase_if(hosts_, [&](const auto& item) { return purge(item.second, now); });
  for (const auto& [id, host] : hosts_) {
    if (host.state == State::kGreeting || host.state == State::kMissing) due(std::max(host.due, now + 1ms));
    if (host.routable && host.query_due != SteadyTime::max()) due(std::max(host.query_due, now + 1ms));
    if (host.routable && host.left_until > now) due(host.left_until);
  }
  if (!hosts_.empty()) due(now + kForgetTime / 4);
}

void Hosts::sweep(Host& host, SteadyTime now) {
  if (host.state == State::kGreeting && host.due <= now) return become_up(host);
  if (host.state == State::kMissing && host.due <= now) return lose(host);
  if (host.routable && host.state == State::kAbsent && host.informed) return evaluate(host);
  if (host.routable && !host.informed && host.query_due <= now) ask(host, now);
}

bool Hosts::purge(const Host& host, SteadyTime now) const {
  return host.state == State::kAbsent && !host.routable && now - host.heard >= kForgetTime;
}

bool Hosts::is_over(OwnerId id, std::uint32_t magic) const {
  const auto found = hosts_.find(id);
  if (found == hosts_.end()) return false;
  const auto now = scheduler_.now();
  const auto& former = found->second.former;
  return std::any_of(former.begin(), former.end(),
                     [&](const Former& start) { return start.magic == magic && magic != 0 && now < start.until; });
}

bool Hosts::is_up(OwnerId id) const {
  return find(id) != nullptr;
}

bool Hosts::is_routable(OwnerId id) const {
  const auto found = hosts_.find(id);
  return found != hosts_.end() && found->second.routable;
}

bool Hosts::is_ours(OwnerId id) const {
  const auto found = hosts_.find(id);
  return found != hosts_.end() && found->second.identity.hello.has_value();
}

std::optional<Duration> Hosts::lease(OwnerId id) const {
  const auto found = hosts_.find(id);
  if (found == hosts_.end() || !found->second.identity.hello) return std::nullopt;
  return found->second.identity.hello->lease;
}

const Identity* Hosts::find(OwnerId id) const {
  const auto found = hosts_.find(id);
  if (found == hosts_.end()) return nullptr;
  const auto state = found->second.state;
  return state == State::kUp || state == State::kMissing ? &found->second.identity : nullptr;
}

const HostRecord* Hosts::record(OwnerId id) const {
  const auto found = hosts_.find(id);
  return found != hosts_.end() && found->second.informed ? &found->second.record : nullptr;
}

const HostRecord* Hosts::claim(OwnerId id) const {
  const auto found = hosts_.find(id);
  return found != hosts_.end() && found->second.claim ? &*found->second.claim : nullptr;
}

std::vector<Identity> Hosts::up() const {
  std::vector<Identity> up;
  for (const auto& [id, host] : hosts_) {
    if (host.state == State::kUp || host.state == State::kMissing) up.push_back(host.identity);
  }
  return up;
}

}  // namespace rubicon::tuples::peis
