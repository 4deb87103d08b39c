#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/limited_log.h"
#include "client/message_client.h"
#include "client/peer_discovery.h"
#include "history/history_source.h"
#include "tuples/space_rights.h"
#include "web/access/access.h"
#include "web/api/allowances.h"
#include "web/api/event_types.h"
#include "web/api/permission.h"
#include "web/api/recent_reads.h"
#include "web/api/shared_demands.h"

namespace rubicon::web::api {

/// How the API describes itself, and what it shows.
struct ApiOptions {
  std::string name{};                         ///< of the component, for people
  std::string place{};                        ///< where it looks for islands, for people; empty: it belongs to one
  std::string place_options{};                ///< the same as options of the command line
  std::vector<Pattern> metrics_patterns{};    ///< points whose values `/metrics` shows
  history::HistorySource* history = nullptr;  ///< must outlive the API; nullptr = there is none
  OwnerId island = model::kNoOwner;           ///< that it belongs to, whose rights hold here; kNoOwner = roles alone
};

/// What all requests and conversations share; outlives them.
struct Context {
  Context(Scheduler& a_scheduler, TupleSpace& a_space, base::LogSink& log, access::Access& its_access,
          ApiOptions its_options)
      : scheduler(a_scheduler),
        space(a_space),
        access(its_access),
        options(std::move(its_options)),
        permission(options.island == model::kNoOwner ? nullptr : tuples::SpaceRights::judge(a_space), options.island),
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
