#include "tuples/memory/memory_ecology.h"

#include <fmt/format.h>

#include <map>
#include <set>
#include <utility>

#include "tuples/peer_policy.h"

namespace rubicon::tuples {

namespace {

/// A Change that owns its bytes while it waits for the next turn.
struct ChangeCopy {
  explicit ChangeCopy(const Change& change)
      : kind(change.kind),
        tuple(change.tuple),
        key(change.tuple.key),
        value(change.tuple.value),
        media_type(change.tuple.media_type) {}

  Change view() const {
    Change change{kind, tuple};
    change.tuple.key = key;
    change.tuple.value = value;
    change.tuple.media_type = media_type;
    return change;
  }

  EventKind kind;
  TupleView tuple;
  std::string key;
  std::string value;
  std::string media_type;
};

std::pair<OwnerId, OwnerId> unordered_pair(OwnerId a, OwnerId b) {
  return a < b ? std::pair(a, b) : std::pair(b, a);
}

}  // namespace

/// The members and what separates them; links and posted deliveries share it, so either may go first.
struct MemoryEcology::Shared : std::enable_shared_from_this<MemoryEcology::Shared> {
  struct Member {
    std::uint64_t incarnation = 0;
    LinkListener* listener = nullptr;
    std::map<std::uint32_t, SubscriptionSpec> subscriptions;
    std::string summary;
  };

  explicit Shared(Scheduler& s) : scheduler(s) {}

  bool reachable(OwnerId from, OwnerId to) const {
    return from != to && members.contains(to) && !cuts.contains(unordered_pair(from, to));
  }

  /// Deliveries carry the incarnation of both ends and the epoch of their connection: what was under way when either
  /// went or the pair was cut is lost with it.
  template <class Call>
  void deliver(OwnerId from, OwnerId to, Call call) {
    if (!reachable(from, to)) return;
    const auto sender = members.at(from).incarnation;
    const auto receiver = members.at(to).incarnation;
    const auto epoch = epochs[unordered_pair(from, to)];
    scheduler.post([shared = shared_from_this(), from, to, sender, receiver, epoch, call = std::move(call)] {
      if (!shared->is_present(from, sender) || shared->epochs[unordered_pair(from, to)] != epoch) return;
      shared->tell(to, receiver, call);
    });
  }

  bool is_present(OwnerId id, std::uint64_t incarnation) const {
    const auto found = members.find(id);
    return found != members.end() && found->second.incarnation == incarnation;
  }

  template <class Call>
  void tell(OwnerId to, std::uint64_t incarnation, const Call& call) {
    if (!is_present(to, incarnation)) return;
    if (auto* listener = members.at(to).listener) call(*listener);
  }

  void announce(OwnerId peer, PeerEvent event, OwnerId to) {
    const auto incarnation = members.at(to).incarnation;
    scheduler.post([shared = shared_from_this(), peer, event, to, incarnation] {
      shared->tell(to, incarnation, [&](LinkListener& listener) { listener.on_peer(peer, event); });
    });
  }

  /// Tells `to` that `from` is there and what it subscribes to.
  void introduce(OwnerId from, OwnerId to) {
    deliver(from, to, [from](LinkListener& listener) { listener.on_peer(from, PeerEvent::kUp); });
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
  std::map<OwnerId, Member> members;
  std::set<std::pair<OwnerId, OwnerId>> cuts;
  std::map<std::pair<OwnerId, OwnerId>, std::uint64_t> epochs;
  std::uint64_t incarnations = 0;
};

/// One member's end. A member is visible to others from its attach on, so that no announcement is missed.
class MemoryEcology::MemoryLink final : public Link {
 public:
  MemoryLink(OwnerId self, std::shared_ptr<Shared> shared) : self_(self), shared_(std::move(shared)) {}

  ~MemoryLink() override {
    leave();
    shared_->members.erase(self_);
  }

  void attach(LinkListener* listener) override {
    leave();
    auto& me = shared_->members.at(self_);
    me.listener = listener;
    if (!listener) return;
    shared_->each_reachable(self_, [&](OwnerId peer) {
      shared_->introduce(peer, self_);
      shared_->introduce(self_, peer);
    });
  }

  bool publish(OwnerId subscriber, std::span<const Change> changes) override {
    std::vector<ChangeCopy> copies(changes.begin(), changes.end());
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

  Result<void> remote_set(const RemoteSet& wish) override {
    if (!shared_->reachable(self_, wish.owner) || !shared_->members.at(wish.owner).listener) {
      return fail(ErrorCode::kNotFound, fmt::format("no component {} in the ecology", number(wish.owner)));
    }
    shared_->deliver(self_, wish.owner, [wish](LinkListener& l) { l.on_remote_set(wish); });
    return {};
  }

  void reply(const Reply& reply) override {
    shared_->deliver(self_, reply.to, [reply](LinkListener& l) { l.on_reply(reply); });
  }

  void describe(std::string summary) override {
    auto& me = shared_->members.at(self_);
    me.summary = std::move(summary);
    if (!me.listener) return;
    shared_->each_reachable(self_, [&](OwnerId peer) {
      shared_->deliver(self_, peer, [from = self_, told = me.summary](LinkListener& l) { l.on_summary(from, told); });
    });
  }

  PeerPolicy& policy() override { return policy_; }

  std::vector<OwnerId> peers() const override {
    std::vector<OwnerId> there;
    shared_->each_reachable(self_, [&](OwnerId peer) { there.push_back(peer); });
    return there;
  }

 private:
  /// A new incarnation: what is under way to or from the old one is lost, the others hear that it left.
  void leave() {
    auto& me = shared_->members.at(self_);
    if (me.listener) {
      shared_->each_reachable(self_, [&](OwnerId peer) { shared_->announce(self_, PeerEvent::kLeft, peer); });
    }
    me.listener = nullptr;
    me.subscriptions.clear();
    me.incarnation = ++shared_->incarnations;
  }

  OwnerId self_;
  OpenPolicy policy_;
  std::shared_ptr<Shared> shared_;
};

MemoryEcology::MemoryEcology(Scheduler& scheduler) : shared_(std::make_shared<Shared>(scheduler)) {}
MemoryEcology::~MemoryEcology() = default;

Result<std::unique_ptr<Link>> MemoryEcology::join(OwnerId id) {
  if (shared_->members.contains(id)) {
    return fail(ErrorCode::kDuplicate, fmt::format("component {} is already in the ecology", number(id)));
  }
  shared_->members[id].incarnation = ++shared_->incarnations;
  return std::make_unique<MemoryLink>(id, shared_);
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
