#pragma once

#include <memory>
#include <string>

#include "base/log.h"
#include "base/scheduler.h"
#include "config/service_config.h"
#include "rubicon/tuple_space.hpp"
#include "transport/transports.h"

namespace boost::asio {
class io_context;
}

namespace rubicon::history {
class HistorySource;
}

namespace rubicon::web {

class Importer;

/// The page and its API on a tuple space, until it is destroyed: server, site, tokens and files.
class WebService {
 public:
  /// Must outlive it.
  struct Parts {
    boost::asio::io_context& context;
    Scheduler& scheduler;
    TupleSpace& space;
    transport::Transports& transports;
    LogSink& log;
    history::HistorySource* history = nullptr;  ///< nullptr = there is none
    OwnerId island = model::kNoOwner;           ///< that it belongs to, whose rights hold here; kNoOwner = none
    Importer* importer = nullptr;               ///< nullptr = there is none
    bool closed = false;  ///< the host has users who may not do what they like here: loopback is open to all of them
  };

  /// Where a component that belongs to no island looks for islands.
  struct Place {
    std::string text;     ///< for people: `domain 3 on eth0`
    std::string options;  ///< of the command line: `--domain 3 --interfaces eth0`
  };

  /// Relative paths start at `directory`. kBusy: the port is in use; kRefused: the ecology is closed to others, and
  /// there are no tokens; otherwise what is wrong with a file that the setup names, or why nothing can listen.
  static Result<std::unique_ptr<WebService>> open(const Parts& parts, const config::WebSetup& setup,
                                                  const std::string& directory, const std::string& name,
                                                  const Place& place = {});
  ~WebService();

  /// Reads tokens and certificate again. On an error those before stay. Where there are rights, all connections are
  /// closed once: they may have changed.
  Result<void> reload();
  /// `http://127.0.0.1:8642`
  std::string address() const;

 private:
  struct Impl;
  explicit WebService(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// What is wrong with the files that a setup names: one line each, with the key that names it (`tls`, `tokens`,
/// `files`).
std::vector<std::pair<std::string, std::string>> faults_of_files(transport::Transports& transports,
                                                                 const config::WebSetup& setup,
                                                                 const std::string& directory);

}  // namespace rubicon::web
