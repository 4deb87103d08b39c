#include <cstdlib>

#include "fuzz_target.h"
#include "networks/knx/groups/group_list.h"
#include "networks/knx/groups/infer_points.h"

namespace rubicon::fuzz::knx_xml_fuzz {

/// Input: a group address list as XML export.
FUZZ_TARGET(knx_xml) {
  using namespace rubicon::networks::knx::groups;
  auto list = read_xml({reinterpret_cast<const char*>(data), size});
  if (list.report.refused && !list.entries.empty()) std::abort();
  if (list.report.taken != list.entries.size() && !list.report.refused) std::abort();
  if (infer_points(list.entries, true, list.report).size() > list.entries.size()) std::abort();
  return 0;
}

}  // namespace rubicon::fuzz::knx_xml_fuzz
