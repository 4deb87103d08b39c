#include "config/audit_config.h"

#include "trust/rights/rule.h"

namespace rubicon::config {

AuditSetup read_audit(ConfigReader& root) {
  auto audit = root.map("audit");
  AuditSetup setup;
  setup.file = audit.text("file", "");
  if (audit.has("file") && setup.file.empty()) audit.error("file", "empty path, expected a file");
  setup.hide = audit.texts("hide");
  for (const auto& key : setup.hide) {
    if (const auto good = trust::rights::check_rule_key(key); !good) audit.error("hide", good.error().text);
  }
  setup.size = audit.size("size", setup.size, kSmallestAudit);
  audit.finish();
  return setup;
}

}  // namespace rubicon::config
