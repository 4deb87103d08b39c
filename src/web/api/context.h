#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "base/log.h"
#include "base/scheduler.h"
#include "client/message_client.h"
#include "client/tuple_query.h"
#include "history/history_source.h"
#include "model/type_catalogue.h"
#include "rubicon/time.hpp"
#include "rubicon/tuple_space.hpp"
#include "tuples/peer_policy.h"
#include "web/access/access.h"
#include "web/api/permission.h"
#include "web/importer.h"

namespace rubicon::web::api {

/// How often something is allowed: so many times in each second, which may come at once.
class Allowance {
 public:
  explicit Allowance(unsigned per_second) : most_(per_second), left_(per_second) {}

  /// False: not now.
  bool take(SteadyTime now) {
    if (now > last_) {
      left_ = std::min(most_, left_ + most_ * std::chrono::duration<double>(now - last_).count());
      last_ = now;
    }
    if (left_ < 1) return false;
    left_ -= 1;
    return true;
  }
  /// Something cost more than was known when it was allowed: the next ones wait.
  void charge(double more) { left_ -= more; }
  /// As without use.
  bool is_full(SteadyTime now) const {
    return left_ + most_ * std::chrono::duration<double>(now - last_).count() >= most_;
  }

 private:
  double most_, left_;
  SteadyTime last_{};
};

/// An Allowance for each caller. Bounded: callers whose allowance is full are forgotten, and beyond kMaxCount new
/// ones share one allowance.
class Allowances {
 public:
  explicit Allowances(unsigned per_second) : per_second_(per_second), shared_(per_second) {}

  bool take(const std::string& caller, SteadyTime now) { return of(caller, now).take(now); }
  /// See Allowance::charge().
  void charge(const std::string& caller, SteadyTime now, double more) { of(caller, now).charge(more); }

 private:
  Allowance& of(const std::string& caller, SteadyTime now) {
    const auto known = callers_.find(caller);
    if (known != callers_.end()) return known->second;
    if (callers_.size() >= kMaxCount)
      std::erase_if(callers_, [now](const auto& one) { return one.second.is_full(now); });
    if (callers_.size() >= kMaxCount) return shared_;
    return callers_.emplace(caller, Allowance(per_second_)).first->second;
  }

  static constexpr std::size_t kMaxCount = 1024;

  unsigned per_second_;
  Allowance shared_;
  std::map<std::string, Allowance> callers_;
};

/// What the sets of a tuple are.
enum class Sets : std::uint8_t {
  kUnknown,  ///< an open type without a description of events so far: they count as states
  kStates,   ///< only the latest counts
  kEvents,   ///< each one counts (button, scene)
};

/// Tells which tuples hold events and which states; only the values of points may hold events.
/// Learns open types, which the catalogue does not know, from the description of one point of each.
class EventTypes {
 public:
  explicit EventTypes(TupleSpace& space) : space_(space) {}

  /// Other than kUnknown, the answer for a key is final.
  Sets sets_of(OwnerId owner, std::string_view key);

 private:
  /// Open types that are known at a time; the points of others count as states.
  static constexpr std::size_t kMaxOpenTypes = 4096;
  struct OpenType {
    bool is_event = false;
    tuples::Handle description;
  };
  bool is_open_event(OwnerId owner, std::string_view key, std::string_view type);

  TupleSpace& space_;
  model::TypeCatalogue catalogue_;
  std::map<std::pair<OwnerId, std::string>, OpenType, std::less<>> open_types_;
};

/// Keeps the copies of tuples that were read lately: a client that asks again soon, or for the next page, need not wait
/// until all owners sent them again.
class RecentReads {
 public:
  static constexpr Duration kTime = std::chrono::seconds(60);

  RecentReads(Scheduler& scheduler, TupleSpace& space) : scheduler_(scheduler), space_(space) {}

  /// Until kTime after the last call with the same pattern. Not for patterns that a client chooses: they are not
  /// bounded.
  void keep(const Pattern& pattern);

 private:
  struct Kept {
    tuples::Handle subscription;
    Timer end;
  };

  Scheduler& scheduler_;
  TupleSpace& space_;
  std::map<std::string, Kept> kept_;
};

/// The demand of callers whose rights decide about each tuple: one subscription for each tuple and pace, which all
/// connections share. Outlives all shares.
class SharedDemands {
 public:
  static constexpr std::size_t kMax = 8000;  ///< an owner takes 10,000 subscriptions of a component

  explicit SharedDemands(TupleSpace& space) : space_(space) {}
  SharedDemands(const SharedDemands&) = delete;
  SharedDemands& operator=(const SharedDemands&) = delete;

  /// The demand lasts as long as one of its shares.
  class Demand;
  using Share = std::shared_ptr<Demand>;
  /// nullptr: there are kMax.
  Share of(OwnerId owner, std::string_view key, const Flow& flow);
  std::size_t size() const { return demands_.size(); }

 private:
  using Name = std::tuple<OwnerId, std::string, Duration, Duration, double>;

  TupleSpace& space_;
  std::map<Name, std::weak_ptr<Demand>> demands_;
};

/// How the API describes itself, and what it shows.
struct ApiOptions {
  std::string name{};                         ///< of the component, for people
  std::string place{};                        ///< where it looks for islands, for people; empty: it belongs to one
  std::string place_options{};                ///< the same as options of the command line
  std::vector<Pattern> metrics_patterns{};    ///< points whose values `/metrics` shows
  history::HistorySource* history = nullptr;  ///< must outlive the API; nullptr = there is none
  OwnerId island = model::kNoOwner;           ///< its island, whose rights apply; kNoOwner: only roles apply
  Importer* importer = nullptr;               ///< must outlive the API; nullptr = there is none
};

/// What all requests and conversations share; outlives them.
struct Context {
  Context(Scheduler& a_scheduler, TupleSpace& a_space, base::LogSink& log, access::Access& its_access,
          ApiOptions its_options)
      : scheduler(a_scheduler),
        space(a_space),
        access(its_access),
        options(std::move(its_options)),
        permission(options.island == model::kNoOwner ? nullptr : tuples::SpaceRights::judge(a_space), options.island,
                   its_access.rules().needs_token),
        set_log(std::make_shared<base::LimitedLog>(Log(log, "web"), a_scheduler)),
        messages(a_scheduler, a_space, log),
        peers(a_scheduler, a_space, client::kDdsPace),  // it was there long before a request
        event_types(a_space),
        recent_reads(a_scheduler, a_space),
        demands(a_space) {}

  static constexpr unsigned kCommandsPerSecond = 50;
  static constexpr unsigned kHistoryReadsPerSecond = 5;
  static constexpr unsigned kListsPerSecond = 30;        ///< each counts once, and
  static constexpr std::size_t kTuplesOfAList = 20'000;  ///< once more for so many tuples

  /// Counters for `/metrics`.
  struct Counters {
    std::uint64_t requests = 0, errors = 0, frames_in = 0, frames_out = 0, bytes_out = 0, commands = 0, busy = 0,
                  lost_events = 0;
    std::size_t conversations = 0, streams = 0, subscriptions = 0;  ///< at present
  };

  Scheduler& scheduler;
  TupleSpace& space;
  access::Access& access;
  ApiOptions options;
  Permission permission;
  std::shared_ptr<base::LimitedLog> set_log;  ///< which token asked for a set; pending replies share it
  client::MessageClient messages;
  client::PeerDiscovery peers;
  EventTypes event_types;
  RecentReads recent_reads;
  SharedDemands demands;
  Allowances commands{kCommandsPerSecond}, history_reads{kHistoryReadsPerSecond},
      lists{kListsPerSecond};  ///< of callers over HTTP
  Counters counters;
};

}  // namespace rubicon::web::api
