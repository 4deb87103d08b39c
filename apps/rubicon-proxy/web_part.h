#pragma once

#include <memory>
#include <optional>
#include <string>

#include "base/log.h"
#include "config/web_config.h"
#include "history/history.h"
#include "rubicon/tuple_space.hpp"
#include "transport/asio_scheduler.h"
#include "transport/transports.h"
#include "tuples/link.h"
#include "web/web_service.h"

namespace rubicon::daemon {

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
    bool closed = false;  ///< as WebService::Parts has it
  };

  WebPart(const Host& host, OwnerId id, std::string name)
      : host_(host), id_(id), name_(std::move(name)), log_(host.log, "web") {}

  /// Opens, changes or closes the page; where the setup is the one before, reads its files again.
  /// `history` may be nullptr; another one needs take() without a setup before.
  void take(const std::optional<config::WebSetup>& setup, const std::string& directory, history::History* history);

 private:
  Result<void> open(const config::WebSetup& setup, const std::string& directory, history::History* history);
  void close();

  Host host_;
  OwnerId id_;
  std::string name_;
  Log log_;
  std::optional<config::WebSetup> setup_;  ///< of the page that is open
  std::unique_ptr<tuples::Link> link_;
  std::unique_ptr<TupleSpace> space_;
  std::unique_ptr<web::WebService> service_;
};

}  // namespace rubicon::daemon
