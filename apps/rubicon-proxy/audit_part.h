#pragma once

#include <memory>

#include "base/log.h"
#include "base/scheduler.h"
#include "island/island_config.h"
#include "trust/rights/audit_file.h"
#include "trust/rights/rights_judge.h"

namespace rubicon::daemon {

/// The audit of the daemon's judge.
class AuditPart {
 public:
  /// `lines` gets what the audit file gets: only the user of the island may see that log. All must outlive it.
  AuditPart(Scheduler& scheduler, LogSink& log, LogSink& lines)
      : scheduler_(scheduler), log_(log, "audit"), lines_(lines, "audit") {}

  /// Opens the file that the configuration names, unless it is open, and takes its other options. The error says why it
  /// cannot be written; the one before stays.
  Result<void> take(const island::IslandConfig& config, trust::rights::RightsJudge& judge);
  /// Another judge records there too.
  void share(trust::rights::RightsJudge& judge) { judge.record_by(file_); }
  /// Opens its file again: logrotate may have renamed it.
  void reopen() {
    if (file_) file_->reopen();
  }

 private:
  Scheduler& scheduler_;
  Log log_, lines_;
  std::string path_;
  std::shared_ptr<trust::rights::AuditFile> file_;
};

}  // namespace rubicon::daemon
