#pragma once

#include "tuples/carry/carrier.h"
#include "tuples/joined/two_engines.h"
#include "tuples/peer_policy.h"

namespace rubicon::tuples::carry {

using joined::Observer;

/// Refuses the remote sets of some components, and limits what all get of some keys.
class PickyPolicy final : public OpenPolicy {
 public:
  using Limits = std::map<std::string, Access, std::less<>>;
  PickyPolicy(const std::set<OwnerId>& refused, const Limits& limits, std::vector<Reply>& answers)
      : refused_(refused), limits_(limits), answers_(answers) {}
  Result<void> may_set(const RemoteSet& set) override {
    if (refused_.contains(set.from)) return fail(ErrorCode::kRefused, "not from this host");
    return {};
  }
  void answered(const RemoteSet&, const Reply& reply) override { answers_.push_back(reply); }
  bool filters(OwnerId) const override { return !limits_.empty(); }
  Access access(OwnerId, std::string_view key) const override {
    const auto found = limits_.find(key);
    return found == limits_.end() ? Access() : found->second;
  }

 private:
  const std::set<OwnerId>& refused_;
  const Limits& limits_;
  std::vector<Reply>& answers_;
};

/// An engine in memory whose readers may stop reading, and whose links may refuse remote sets.
class TestEngine final : public StandInEcology {
 public:
  explicit TestEngine(VirtualScheduler& time, const std::string& host) : memory(time, host) {}
  Result<std::unique_ptr<Link>> join(OwnerId id) override { return wrapped(memory.join(id)); }
  Result<std::unique_ptr<Link>> join_as(StandIn who) override {
    displaced[who.id] = who.displaced;
    return wrapped(memory.join_as(std::move(who)));
  }

  MemoryEcology memory;
  std::set<OwnerId> refused;   ///< remote sets of these are
  PickyPolicy::Limits limits;  ///< what peers get of these keys; empty = all of all
  std::vector<Reply> answers;  ///< that policies were told of
  std::set<OwnerId> stalled;   ///< nothing is published to these
  std::map<OwnerId, std::function<void()>> displaced;

 private:
  class TestLink final : public Link {
   public:
    TestLink(std::unique_ptr<Link> link, TestEngine& engine)
        : link_(std::move(link)), engine_(engine), policy_(engine.refused, engine.limits, engine.answers) {}
    void attach(LinkListener& listener, std::uint64_t incarnation) override { link_->attach(listener, incarnation); }
    void detach() override { link_->detach(); }
    bool publish(OwnerId subscriber, std::span<const Change> changes) override {
      return !engine_.stalled.contains(subscriber) && link_->publish(subscriber, changes);
    }
    void subscribe(const SubscriptionSpec& spec) override { link_->subscribe(spec); }
    void unsubscribe(std::uint32_t id) override { link_->unsubscribe(id); }
    Result<void> remote_set(const RemoteSet& set) override { return link_->remote_set(set); }
    void reply(const Reply& reply) override { link_->reply(reply); }
    std::vector<OwnerId> peers() const override { return link_->peers(); }
    void describe(std::string summary) override { link_->describe(std::move(summary)); }
    PeerPolicy& policy() override { return policy_; }

   private:
    std::unique_ptr<Link> link_;
    TestEngine& engine_;
    PickyPolicy policy_;
  };

  Result<std::unique_ptr<Link>> wrapped(Result<std::unique_ptr<Link>> link) {
    if (!link) return link;
    return std::make_unique<TestLink>(std::move(*link), *this);
  }
};

/// In all directions.
inline CarryRules rules_of(const std::vector<std::string>& entries, std::size_t most = 1000) {
  CarryRules rules{{{}}, most};
  for (const auto& entry : entries) EXPECT_TRUE(add_entry(rules.rules[0], entry));
  return rules;
}

/// An island with both engines, which carries.
struct CarryingIsland {
  CarryingIsland(TestEngine& dds, TestEngine& peis, VirtualScheduler& time, base::LogSink& log, std::uint32_t id,
                 const std::vector<std::string>& entries, std::size_t most = 1000)
      : carrier(OwnerId(id), rules_of(entries, most), {{"dds", dds}, {"peis", peis}}, time, log),
        both({{"dds", carrier.engine(0)}, {"peis", carrier.engine(1)}}, time, log),
        self(both, time, id) {}

  Carrier carrier;
  joined::JoinedEcology both;
  Observer self;
};

/// A component with a lamp that others may set, and a sensor that is measured on demand.
struct Home : Observer {
  Home(Ecology& ecology, VirtualScheduler& time, std::uint32_t id) : Observer(ecology, time, id) {
    EXPECT_TRUE(space.set("kitchen.lamp", "off"));
    EXPECT_TRUE(space.set("kitchen.log", "a"));
    EXPECT_TRUE(space.set("hall.lamp", "off"));
  }
  Demand demand;
  Handle watch_demand = space.watch_demand(pattern("kitchen.lamp"), [this](const Demand& now) { demand = now; });
  std::vector<RemoteSet> sets;
  Handle policy = space.add_policy(
      pattern("**"),
      [this](const RemoteSet& set) {
        sets.push_back(set);
        if (set.value == "bad") return SetDecision::refused({ErrorCode::kInvalid, "no such word"});
        return SetDecision::applied();
      },
      PolicyScope::kSetsAndAppends);
};

struct Carrying : testing::Test {
  void SetUp() override { time.run_for(std::chrono::seconds(1)); }
  /// Long enough for stand-ins to begin.
  void settle() { time.run_for(std::chrono::seconds(3)); }
  /// A second starts at each call, so that no two components have the same start.
  template <class Member = Observer>
  std::unique_ptr<Member> join(Ecology& ecology, std::uint32_t id) {
    time.run_for(std::chrono::seconds(1));
    auto component = std::make_unique<Member>(ecology, time, id);
    time.run_ready();
    return component;
  }
  std::unique_ptr<CarryingIsland> carry(const std::vector<std::string>& entries, std::uint32_t id = 1,
                                        std::size_t most = 1000) {
    time.run_for(std::chrono::seconds(1));
    return std::make_unique<CarryingIsland>(dds, peis, time, log, id, entries, most);
  }

  VirtualScheduler time;
  support::CollectingLog log;
  TestEngine dds{time, "here"}, peis{time, "there"};
};

}  // namespace rubicon::tuples::carry
