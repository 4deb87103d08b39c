#include "tuples/memory/memory_ecology.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "tuples/link.h"
#include "tuples/peer_policy.h"
#include "tuples/refusals.h"

namespace rubicon::tuples {

namespace {

std::pair<OwnerId, OwnerId> unordered_pair(OwnerId a, OwnerId b) {
  return a < b ? std::pair(a, b) : std::pair(b, a);
}

}  // namespace

/// The members and the cuts between them; shared by the links and the posted deliveries, which may outlive each other.
struct MemoryEcology::Shared : std::enable_shared_from_this<MemoryEcology::Shared> {
  struct Member {
    std::uint64_t visit = 0;  ///< of one attach()
    std::uint64_t incarnation = 0;
    LinkListener* listener = nullptr;
    std::map<std::uint32_t, SubscriptionSpec> subscriptions;
    std::string summary;
    std::string host;
    std::unique_ptr<PeerPolicy> policy = std::make_unique<OpenPolicy>();
  };

  Shared(Scheduler& s, std::string all_on) : scheduler(s), host(std::move(all_on)) {}

  bool reachable(OwnerId from, OwnerId to) const {
    return from != to && members.contains(to) && !cuts.contains(unordered_pair(from, to));
  }

  /// A delivery carries the visits of both ends and the epoch of their connection. It is lost if either end
  /// leaves or the connection is cut before it arrives.
  template <class Call>
  void deliver(OwnerId from, OwnerId to, Call call) {
    if (!reachable(from, to)) return;
    const auto sender = members.at(from).visit;
    const auto receiver = members.at(to).visit;
    const auto epoch = epochs[unordered_pair(from, to)];
    scheduler.post([shared = shared_from_this(), from, to, sender, receiver, epoch, call = std::move(call)] {
      if (!shared->is_present(from, sender) || shared->epochs[unordered_pair(from, to)] != epoch) return;
      shared->call_listener(to, receiver, call);
    });
  }

  bool is_present(OwnerId id, std::uint64_t visit) const {
    const auto found = members.find(id);
    return found != members.end() && found->second.visit == visit;
  }

  template <class Call>
  void call_listener(OwnerId to, std::uint64_t visit, const Call& call) {
    if (!is_present(to, visit)) return;
    if (auto* listener = members.at(to).listener) call(*listener);
  }

  PeerIdentity identity(OwnerId id) const {
    const auto certified = certificates.find(id);
    const auto who = certified == certificates.end() ? nullptr : certified->second;
    return {id, members.at(id).incarnation, members.at(id).host, who, who == nullptr};
  }

  void announce(OwnerId peer, PeerEvent event, OwnerId to) {
    scheduler.post([shared = shared_from_this(), who = identity(peer), event, to, visit = members.at(to).visit] {
      if (!shared->is_present(to, visit)) return;
      shared->members.at(to).policy->peer_down(who.id);
      shared->call_listener(to, visit, [&](LinkListener& listener) { listener.on_peer(who, event); });
    });
  }

  std::unique_ptr<PeerPolicy> make_policy(OwnerId id) const {
    const auto found = judges.find(id);
    if (found == judges.end()) return std::make_unique<OpenPolicy>();
    return std::make_unique<MemberPolicy>(id, found->second);
  }

  /// Reports to `to` that `from` is up, its summary and its subscriptions.
  void introduce(OwnerId from, OwnerId to) {
    deliver(from, to, [who = identity(from), to, this](LinkListener& listener) {
      members.at(to).policy->peer_up(who);
      listener.on_peer(who, PeerEvent::kUp);
    });
    if (const auto& summary = members.at(from).summary; !summary.empty())
      deliver(from, to, [from, summary](LinkListener& listener) { listener.on_summary(from, summary); });
    for (const auto& subscription : members.at(from).subscriptions) {
      deliver(from, to,
              [from, spec = subscription.second](LinkListener& listener) { listener.on_subscribe(from, spec); });
    }
  }

  template <class Visit>
  void each_reachable(OwnerId from, Visit visit) {
    for (const auto& [id, member] : members) {
      if (member.listener && reachable(from, id)) visit(id);
    }
  }

  Scheduler& scheduler;
  std::string host;
  std::map<OwnerId, Member> members;
  std::map<OwnerId, std::shared_ptr<const tuples::Member>> certificates;
  std::map<OwnerId, std::shared_ptr<Judge>> judges;
  std::set<std::pair<OwnerId, OwnerId>> cuts;
  std::map<std::pair<OwnerId, OwnerId>, std::uint64_t> epochs;
  std::uint64_t visits = 0;
};

/// The link of one member, which is visible to the others from attach() on, so that it misses no announcement.
class MemoryEcology::MemoryLink final : public Link {
 public:
  MemoryLink(OwnerId self, std::shared_ptr<Shared> shared) : self_(self), shared_(std::move(shared)) {}

  ~MemoryLink() override {
    leave();
    shared_->members.erase(self_);
  }

  void attach(LinkListener& listener, std::uint64_t incarnation) override {
    leave();
    auto& me = shared_->members.at(self_);
    me.listener = &listener;
    me.incarnation = std::max(incarnation, me.incarnation + 1);
    shared_->each_reachable(self_, [&](OwnerId peer) {
      shared_->introduce(peer, self_);
      shared_->introduce(self_, peer);
    });
  }

  void detach() override { leave(); }

  bool publish(OwnerId subscriber, std::span<const Change> changes) override {
    std::vector<OwnedChange> copies(changes.begin(), changes.end());
    shared_->deliver(self_, subscriber, [owner = self_, copies = std::move(copies)](LinkListener& listener) {
      std::vector<Change> views;
      views.reserve(copies.size());
      for (const auto& copy : copies) views.push_back(copy.view());
      listener.on_changes(owner, views);
    });
    return true;
  }

  void subscribe(const SubscriptionSpec& spec) override {
    shared_->members.at(self_).subscriptions[spec.id] = spec;
    shared_->each_reachable(self_, [&](OwnerId peer) {
      shared_->deliver(self_, peer, [from = self_, spec](LinkListener& l) { l.on_subscribe(from, spec); });
    });
  }

  void unsubscribe(std::uint32_t id) override {
    shared_->members.at(self_).subscriptions.erase(id);
    shared_->each_reachable(self_, [&](OwnerId peer) {
      shared_->deliver(self_, peer, [from = self_, id](LinkListener& l) { l.on_unsubscribe(from, id); });
    });
  }

  Result<void> remote_set(const RemoteSet& set) override {
    if (!shared_->reachable(self_, set.owner) || !shared_->members.at(set.owner).listener) {
      return fail(no_component(set.owner));
    }
    shared_->deliver(self_, set.owner, [set](LinkListener& l) { l.on_remote_set(set); });
    return {};
  }

  void reply(const Reply& reply) override {
    shared_->deliver(self_, reply.to, [from = self_, reply](LinkListener& l) { l.on_reply(from, reply); });
  }

  void describe(std::string summary) override {
    auto& me = shared_->members.at(self_);
    me.summary = std::move(summary);
    if (!me.listener) return;
    shared_->each_reachable(self_, [&](OwnerId peer) {
      shared_->deliver(self_, peer,
                       [from = self_, summary = me.summary](LinkListener& l) { l.on_summary(from, summary); });
    });
  }

  PeerPolicy& policy() override { return *shared_->members.at(self_).policy; }

  std::vector<OwnerId> peers() const override {
    std::vector<OwnerId> present;
    shared_->each_reachable(self_, [&](OwnerId peer) { present.push_back(peer); });
    return present;
  }

 private:
  /// Begins a new visit: deliveries to and from the old one are lost; the others see that it left.
  void leave() {
    auto& me = shared_->members.at(self_);
    if (me.listener) {
      shared_->each_reachable(self_, [&](OwnerId peer) { shared_->announce(self_, PeerEvent::kLeft, peer); });
    }
    me.listener = nullptr;
    me.subscriptions.clear();
    me.visit = ++shared_->visits;
  }

  OwnerId self_;
  std::shared_ptr<Shared> shared_;
};

MemoryEcology::MemoryEcology(Scheduler& scheduler, std::string host)
    : shared_(std::make_shared<Shared>(scheduler, std::move(host))) {}
MemoryEcology::~MemoryEcology() = default;

Result<std::unique_ptr<Link>> MemoryEcology::join(OwnerId id) {
  return join_as({id, shared_->host, {}});
}

Result<std::unique_ptr<Link>> MemoryEcology::join_as(StandIn who) {
  const auto id = who.id;
  if (shared_->members.contains(id)) {
    return fail(already_here(id));
  }
  auto& member = shared_->members[id];
  member.visit = ++shared_->visits;
  member.host = std::move(who.host);
  member.policy = shared_->make_policy(id);
  return std::make_unique<MemoryLink>(id, shared_);
}

void MemoryEcology::certify(OwnerId id, Member who) {
  shared_->certificates[id] = std::make_shared<const Member>(std::move(who));
}

void MemoryEcology::judge(OwnerId id, std::shared_ptr<Judge> judge) {
  shared_->judges[id] = std::move(judge);
}

void MemoryEcology::cut(OwnerId a, OwnerId b) {
  const bool were_connected = shared_->reachable(a, b) && shared_->members.contains(a);
  shared_->cuts.insert(unordered_pair(a, b));
  ++shared_->epochs[unordered_pair(a, b)];
  if (!were_connected || !shared_->members.at(a).listener || !shared_->members.at(b).listener) return;
  shared_->announce(a, PeerEvent::kLost, b);
  shared_->announce(b, PeerEvent::kLost, a);
}

void MemoryEcology::mend(OwnerId a, OwnerId b) {
  if (shared_->cuts.erase(unordered_pair(a, b)) == 0) return;
  const auto& members = shared_->members;
  if (!members.contains(a) || !members.contains(b) || !members.at(a).listener || !members.at(b).listener) return;
  shared_->introduce(a, b);
  shared_->introduce(b, a);
}

}  // namespace rubicon::tuples
