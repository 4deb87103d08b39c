#pragma once

#include <functional>
#include <memory>
#include <string>

#include "base/scheduler.h"
#include "island/island.h"
#include "rubicon/result.hpp"
#include "transport/transports.h"
#include "web/importer.h"

namespace rubicon::daemon {

/// Reads projects and exports of ETS for the page (docs/knx-import.md), one at a time, on a worker: a project may take
/// seconds. Keeps nothing of them. Its end waits for the file that is read.
class KnxImporter final : public web::Importer {
 public:
  /// All must outlive it.
  KnxImporter(Scheduler& scheduler, transport::Transports& transports, island::Island& island)
      : scheduler_(scheduler), transports_(transports), island_(island) {}

  void preview(web::ImportRequest request, std::function<void(Result<std::string>)> done) override;

 private:
  std::string known_groups(const std::string& network);

  Scheduler& scheduler_;
  transport::Transports& transports_;
  island::Island& island_;
  std::unique_ptr<transport::Worker> worker_;  ///< while it reads
  base::Lifetime lifetime_;
};

/// What the file becomes, as JSON (docs/api.md, "Import"). `known`: the group file that the network has; empty = none.
/// kInvalid and kRefused say what is wrong with the file, its password, or the choices.
Result<std::string> preview_of(web::ImportRequest request, const std::string& known);

}  // namespace rubicon::daemon
