#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/log.h"
#include "base/scheduler.h"
#include "bridges/bridge.h"
#include "config/service_config.h"
#include "history/history.h"
#include "history/message_questions.h"
#include "island/island.h"
#include "island/island_config.h"
#include "rights/audit.h"
#include "rights/rights_judge.h"
#include "rubicon/tuple_space.hpp"
#include "transport/asio_scheduler.h"
#include "transport/transports.h"
#include "tuples/dds/dds_ecology.h"
#include "tuples/link.h"
#include "web/importer.h"
#include "web/web_service.h"

namespace rubicon::daemon {

/// The audit of the daemon's judge.
class AuditPart {
 public:
  /// `lines` gets what the audit file gets: only the user of the island may see that log. All must outlive it.
  AuditPart(Scheduler& scheduler, LogSink& log, LogSink& lines)
      : scheduler_(scheduler), log_(log, "audit"), lines_(lines, "audit") {}

  /// Opens the file that the configuration names, unless it is open, and takes its other options. The error says why it
  /// cannot be written; the one before stays.
  Result<void> take(const island::IslandConfig& config, rights::RightsJudge& judge);
  /// Another judge records there too.
  void share(rights::RightsJudge& judge) { judge.record_by(file_); }
  /// Opens its file again: logrotate may have renamed it.
  void reopen() {
    if (file_) file_->reopen();
  }

 private:
  Scheduler& scheduler_;
  Log log_, lines_;
  std::string path_;
  std::shared_ptr<rights::AuditFile> file_;
};

/// Errors of the options of bridges, which their types read.
void check_bridges(const std::vector<config::BridgeSetup>& setups, const std::string& directory,
                   base::ConfigErrors& errors);

/// The bridges of an island: components of their own beside it. Each set of one is judged and recorded as the member
/// `bridge:<name>`; without `rights:` the options of the bridge say what it may. The island does not depend on them:
/// one that cannot be opened says so, and is tried again by the next reload.
class BridgesPart {
 public:
  /// All must outlive it.
  struct Host {
    Scheduler& scheduler;
    tuples::Ecology& ecology;
    transport::Transports& transports;
    LogSink& log;
    island::Island& island;  ///< their statuses are tuples of it
    AuditPart& audit;
    std::shared_ptr<rights::RightsJudge> judge;  ///< null: no member is judged
    /// The id of the component of a bridge; asked once for each place below kMaxBridges.
    std::function<OwnerId(std::size_t place)> new_id;
  };

  explicit BridgesPart(Host host);
  ~BridgesPart();

  /// What the configuration of the island names from now on: starts new bridges, ends removed ones, restarts changed
  /// ones, and after a change of the rights all.
  void take();

 private:
  struct One;
  rights::RightsJudge& judge();
  void end_others(bool all);
  Result<void> open(One& one);
  void show();
  std::size_t free_place() const;
  OwnerId id_of(std::size_t place);

  Host host_;
  std::shared_ptr<rights::RightsJudge> own_judge_;  ///< where there are no `rights:`
  std::optional<config::RightsSetup> rights_;       ///< that the bridges run with
  std::vector<OwnerId> ids_;                        ///< by place: a certificate has only some
  std::vector<std::unique_ptr<One>> all_;
  Timer show_;
};

/// The history of an island: a component of its own beside it, as the console is one. The island does not depend on it:
/// where it cannot be opened, the log says why, and it is tried again.
class HistoryPart {
 public:
  /// All must outlive it.
  struct Host {
    Scheduler& scheduler;
    tuples::Ecology& ecology;
    LogSink& log;
    TupleSpace& island;         ///< its status is a tuple of the island
    std::string prefix;         ///< of the keys of the island
    gateway::Gateway& gateway;  ///< questions come there
  };

  HistoryPart(Host host, OwnerId id) : host_(std::move(host)), id_(id), log_(host_.log, "history") {}

  /// Whether take() would change nothing.
  bool has(const std::optional<config::HistorySetup>& setup) const;
  /// Opens, changes or closes the history.
  void take(const std::optional<config::HistorySetup>& setup, const std::string& directory);
  /// nullptr if there is none.
  history::History* history() const { return history_.get(); }

 private:
  Result<void> open(const config::HistorySetup& setup, const std::string& directory);

  Host host_;
  OwnerId id_;
  Log log_;
  std::unique_ptr<tuples::Link> link_;
  std::unique_ptr<TupleSpace> space_;
  std::unique_ptr<history::History> history_;
  std::unique_ptr<history::StatusTuple> status_;
  std::unique_ptr<history::MessageQuestions> questions_;
};

/// The page of an island: a component of its own beside it, as the console is one. The island does not depend on it:
/// where it cannot be opened, a warning says why, and the next reload tries again.
class WebPart {
 public:
  /// Must outlive it.
  struct Host {
    transport::Loop& loop;
    tuples::Ecology& ecology;
    transport::Transports& transports;
    LogSink& log;
    OwnerId island{};
    web::Importer& importer;
    bool closed = false;  ///< as WebService::Parts has it
  };

  WebPart(const Host& host, OwnerId id, std::string name)
      : host_(host), id_(id), name_(std::move(name)), log_(host.log, "web") {}

  /// Opens, changes or closes the page; where the setup is the one before, reads its files again.
  /// `history` may be nullptr; another one needs take() without a setup before.
  void take(const std::optional<config::WebSetup>& setup, const std::string& directory, history::History* history);
  /// `http://127.0.0.1:8642`; empty while there is none.
  std::string address() const { return service_ ? service_->address() : std::string(); }

 private:
  Result<void> open(const config::WebSetup& setup, const std::string& directory, history::History* history);
  void close();

  Host host_;
  OwnerId id_;
  std::string name_;
  Log log_;
  bool is_offered_ = false;                ///< once, to an installed island without a page
  std::optional<config::WebSetup> setup_;  ///< of the page that is open
  std::unique_ptr<tuples::Link> link_;
  std::unique_ptr<TupleSpace> space_;
  std::unique_ptr<web::WebService> service_;
};

/// JSON {interfaces: [{name, address, lack}], changes, changed: seconds since 1970, 0 = never}; empty: there is no
/// news.
std::string interfaces_text(const tuples::dds::InterfaceNews& news);
/// The island shows it as `<prefix>.property.dds-interfaces.value`. The ecology must outlive it.
void show_interfaces(island::Island& island, const tuples::dds::DdsEcology& ecology);

}  // namespace rubicon::daemon
