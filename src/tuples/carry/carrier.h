#pragma once

#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "base/log.h"
#include "base/scheduler.h"
#include "tuples/carry/carry_rules.h"
#include "tuples/carry/engine_side.h"
#include "tuples/carry/forwarded_sets.h"
#include "tuples/carry/passage.h"
#include "tuples/link.h"

namespace rubicon::tuples::carry {

/// Carries tuples of components that are met on some of several engines to others of them
/// (docs/decisions/028-carry.md): there a stand-in takes the place of the component, with its id, its summary and its
/// tuples. A component that reads or commands the stand-in has a stand-in on the owner's engine. Works while the own
/// component is attached to the engines.
///
/// Nothing is carried twice: a stand-in is never carried on, and of several carriers with the same rules between the
/// same two engines the one with the lowest id carries.
class Carrier final : private TapEvents, private StandInEvents {
 public:
  struct Engine {
    std::string name;  ///< as in the configuration
    StandInEcology& ecology;
  };
  /// A component counts as not met on an engine only after this time: engines find it at different times.
  static constexpr Duration kSettle = std::chrono::seconds(2);
  /// A stand-in that only read or commanded stays for this time.
  static constexpr Duration kLinger = std::chrono::seconds(10);

  /// `self`: the component whose view of the engines counts. The engines, the scheduler and the log outlive it.
  Carrier(OwnerId self, CarryRules rules, std::vector<Engine> engines, Scheduler& scheduler, base::LogSink& log);
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
    struct At {
      std::optional<Meeting> meeting;
      SteadyTime held{};  ///< no stand-in there before this
      unsigned collisions = 0;
    };
    std::vector<At> at;    ///< by engine
    SteadyTime changed{};  ///< when an engine met or lost it last
  };
  using StandInKey = std::pair<OwnerId, std::size_t>;            ///< its component, engine where it is
  using PassageKey = std::tuple<OwnerId, OwnerId, std::size_t>;  ///< reader, owner, engine of the owner's stand-in
  using Pairs = std::set<std::pair<std::size_t, std::size_t>>;   ///< of engines, the lower number first

  // TapEvents
  bool on_peer(std::size_t engine, const PeerIdentity& who, PeerEvent event) override;
  void on_summary(std::size_t engine, OwnerId peer, std::string_view summary) override;
  void on_detached(std::size_t engine) override;
  std::string shown(std::string summary) const override;
  // StandInEvents (carrier_passages.cpp)
  void on_changes(const StandInPort& reader, OwnerId owner, std::span<const Change> changes) override;
  void on_subscribe(StandInPort& owner, OwnerId subscriber, const SubscriptionSpec& spec) override;
  void on_unsubscribe(const StandInPort& owner, OwnerId subscriber, std::uint32_t subscription) override;
  void on_remote_set(StandInPort& owner, const RemoteSet& set) override;
  bool on_reply(const StandInPort& reader, OwnerId from, const Reply& reply) override;
  void on_met(const StandInPort& by, OwnerId peer, PeerEvent event) override;

  // Who carries (carrier.cpp)
  void review_carrier(OwnerId id);
  bool gives_way(OwnerId id, std::size_t origin, std::size_t to) const;
  void warn_of_carriers(OwnerId id, const Known& known);

  // Who has a stand-in
  bool hides(std::size_t engine, const PeerIdentity& who, PeerEvent event);
  bool is_met(const Known& known, std::size_t engine) const;
  std::optional<std::size_t> origin_of(OwnerId id, const Known& known, std::size_t to) const;
  bool is_good(const StandInPort& present, const Known& known) const;
  bool is_wanted(OwnerId id, std::size_t origin, std::size_t to) const;
  void review(OwnerId id);
  void review(OwnerId id, std::size_t to);
  void review_at(SteadyTime when, OwnerId id);
  void review_due();
  void begin(OwnerId id, std::size_t origin, std::size_t to);
  std::uint64_t new_incarnation();
  void refuse_excess(OwnerId id);
  void end(OwnerId id, std::size_t engine);
  void displaced(OwnerId id, std::size_t engine, std::uint64_t incarnation);
  StandInPort* find(OwnerId id, std::size_t engine) const;
  Way way_to(const StandInPort& stand_in) const;

  // What passes (carrier_passages.cpp)
  bool serves(const StandInPort& owner, OwnerId reader) const;
  Passage& passage(StandInPort& owner, OwnerId reader);
  bool is_kernel(OwnerId reader) const;
  void observe(StandInPort& owner);
  void met_reader(OwnerId reader);
  void drop_passage(const PassageKey& key);
  void drop_passages_of(OwnerId owner, std::size_t engine);
  void released(OwnerId reader, std::size_t engine);
  void flush_soon(const PassageKey& passage);
  void flush();
  std::string asker(StandInPort& owner, const RemoteSet& set) const;
  Result<void> check(StandInPort& owner, const RemoteSet& set) const;
  void forward(std::uint64_t number);
  void forward_waiting(OwnerId owner, OwnerId reader);
  void answer(const ForwardedSets::Request& request, Reply reply);
  void sets_due();

  OwnerId self_;
  CarryRules rules_;
  std::vector<Engine> engines_;
  Announcement carries_;  ///< of this carrier
  Scheduler& scheduler_;
  base::LimitedLog log_;
  std::deque<TappedEcology> taps_;
  std::map<OwnerId, Known> known_;
  std::vector<std::map<OwnerId, std::uint64_t>> hidden_;  ///< own stand-ins that the engine reported, by start
  std::map<OwnerId, Pairs> others_;                       ///< carriers with the same rules between engines where we are
  std::map<StandInKey, std::shared_ptr<StandInPort>> stand_ins_;
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
