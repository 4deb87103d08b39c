#include "apps/rubicon-proxy/audit_part.h"

#include "island/rights_checks.h"

namespace rubicon::daemon {

Result<void> AuditPart::take(const island::IslandConfig& config, trust::rights::RightsJudge& judge) {
  auto options = island::audit_options(config);
  if (file_ && options.file == path_) {
    file_->change(std::move(options));
    return {};
  }
  auto path = options.file;
  auto opened = trust::rights::AuditFile::open(std::move(options), scheduler_, log_, lines_);
  if (!opened) return fail(std::move(opened.error()));
  path_ = std::move(path);
  file_ = std::move(*opened);
  judge.record_by(file_);
  return {};
}

}  // namespace rubicon::daemon
