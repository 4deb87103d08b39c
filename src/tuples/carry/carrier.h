#pragma once

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include "base/deadline.h"
#include "base/lifetime.h"
#include "base/limited_log.h"
#include "tuples/carry/carry_rules.h"
#include "tuples/carry/forwarded_sets.h"
#include "tuples/carry/passage.h"
#include "tuples/carry/tap.h"
#include "tuples/stand_in.h"

namespace rubicon::tuples::carry {

/// Carries tuples of components that are met on one of two engines to the other one
/// (docs/decisions/022-two-engines.md): there a stand-in takes the place of the component, with its id, its summary and
/// its tuples. Who reads or commands the stand-in has one at the owner's engine. Works while the own component is
/// attached to the engines.
class Carrier final : private TapEvents, private StandInEvents {
 public:
  struct Engine {
    std::string name;  ///< as in the configuration
    StandInEcology& ecology;
  };
  /// A component counts as met on one engine only after this time: engines find it at different times.
  static constexpr Duration kSettle = std::chrono::seconds(2);
  /// A stand-in that only read or commanded stays for this time.
  static constexpr Duration kLinger = std::chrono::seconds(10);

  /// `self`: the component whose view of the engines counts. The engines, the scheduler and the log outlive it.
  Carrier(OwnerId self, CarryRules rules, std::array<Engine, 2> engines, Scheduler& scheduler, base::LogSink& log);
  ~Carrier() override;

  /// The engine for all components of the process. Its links end before this.
  Ecology& engine(std::size_t number) { return taps_[number]; }
  std::size_t stand_ins() const { return stand_ins_.size(); }

 private:
  static constexpr Duration kRetry = std::chrono::milliseconds(5);
  static constexpr std::size_t kStartsPerTurn = 8;  ///< of stand-ins: each takes some milliseconds

  struct Meeting {
    PeerIdentity identity;
    std::string summary;
  };
  /// What the own component sees of an id.
  struct Known {
    std::array<std::optional<Meeting>, 2> at;
    SteadyTime changed{};  ///< when an engine met or lost it last
    SteadyTime held{};     ///< no stand-in before this
    unsigned collisions = 0;
  };
  using PassageKey = std::pair<OwnerId, OwnerId>;  ///< reader, owner

  // TapEvents
  bool on_peer(std::size_t engine, const PeerIdentity& who, PeerEvent event) override;
  void on_summary(std::size_t engine, OwnerId peer, std::string_view summary) override;
  void on_detached(std::size_t engine) override;
  // StandInEvents (carrier_passages.cpp)
  void on_changes(OwnerId id, OwnerId owner, std::span<const Change> changes) override;
  void on_subscribe(OwnerId id, OwnerId subscriber, const SubscriptionSpec& spec) override;
  void on_unsubscribe(OwnerId id, OwnerId subscriber, std::uint32_t subscription) override;
  void on_remote_set(OwnerId id, const RemoteSet& set) override;
  bool on_reply(OwnerId id, OwnerId from, const Reply& reply) override;
  void on_met(OwnerId id, OwnerId peer, PeerEvent event) override;

  // Who has a stand-in
  bool hides(std::size_t engine, const PeerIdentity& who, PeerEvent event);
  void warn_of_carriers(OwnerId id, const Known& known);
  const Meeting* origin_of(const Known& known) const;
  bool is_wanted(OwnerId id, const StandInPort* present) const;
  void review(OwnerId id);
  void review_at(SteadyTime when, OwnerId id);
  void review_due();
  void begin(OwnerId id, std::size_t origin);
  void refuse_excess(OwnerId id);
  void end(OwnerId id);
  void displaced(OwnerId id, std::uint64_t incarnation);
  StandInPort* find(OwnerId id);

  // What passes (carrier_passages.cpp)
  bool serves(const StandInPort& owner, OwnerId reader) const;
  Passage& passage(StandInPort& owner, OwnerId reader);
  bool is_kernel(OwnerId reader) const;
  void observe(StandInPort& owner);
  void met_reader(OwnerId reader);
  void drop_passage(OwnerId reader, OwnerId owner);
  void drop_passages_of(OwnerId owner);
  void released(OwnerId reader);
  void flush_soon(const PassageKey& passage);
  void flush();
  Result<void> check(StandInPort& owner, const RemoteSet& set) const;
  void forward(std::uint64_t number);
  void forward_waiting(OwnerId owner, OwnerId reader);
  void answer(const ForwardedSets::Request& request, Reply reply);
  void sets_due();

  OwnerId self_;
  CarryRules rules_;
  std::array<Engine, 2> engines_;
  Scheduler& scheduler_;
  base::LimitedLog log_;
  std::array<TappedEcology, 2> taps_;
  std::map<OwnerId, Known> known_;
  std::array<std::map<OwnerId, std::uint64_t>, 2> hidden_;  ///< own stand-ins that the engine reported, by start
  std::map<OwnerId, std::shared_ptr<StandInPort>> stand_ins_;
  std::vector<std::shared_ptr<StandInPort>> ended_;  ///< in this turn
  std::uint64_t last_incarnation_ = 0;
  std::map<OwnerId, SteadyTime> reviews_;
  std::set<OwnerId> excess_;  ///< without a stand-in because of the bound
  bool excess_logged_ = false;
  std::map<PassageKey, Passage> passages_;
  std::set<PassageKey> unsent_;  ///< those with changes that wait
  ForwardedSets sets_;
  base::Deadline next_review_{scheduler_, [this] { review_due(); }};
  base::Deadline next_set_{scheduler_, [this] { sets_due(); }};
  base::Deadline retry_{scheduler_, [this] { flush(); }};
  base::OncePerTurn flush_soon_{scheduler_, [this] { flush(); }};
  base::Lifetime lifetime_;
};

}  // namespace rubicon::tuples::carry
