#include <cstdlib>

#include "fuzz_target.h"
#include "networks/knx/groups/group_file.h"
#include "networks/knx/groups/import.h"

namespace rubicon::fuzz::knx_esf_fuzz {

/// Input: a list of any kind, recognised by its content (the seeds are ESF). What is taken must survive the record.
FUZZ_TARGET(knx_esf) {
  using namespace rubicon::networks::knx::groups;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto imported = import_text(text, "fuzz.esf");
  if (!imported) return 0;
  Report report;
  if (merge(imported->points, imported->points, report) != imported->points || report.added != 0) std::abort();
  if (to_yaml(imported->points, "fuzz.esf") != to_yaml(imported->points, "fuzz.esf")) std::abort();
  if (report_text(imported->report).empty()) std::abort();
  return 0;
}

}  // namespace rubicon::fuzz::knx_esf_fuzz
