#include <cstdlib>

#include "networks/knx/groups/infer_points.h"
#include "networks/knx/groups/readers.h"

/// Input: a group address list as XML export.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace rubicon::networks::knx::groups;
  auto list = read_xml({reinterpret_cast<const char*>(data), size});
  if (list.report.refused && !list.entries.empty()) std::abort();
  if (list.report.taken != list.entries.size() && !list.report.refused) std::abort();
  if (infer_points(list.entries, true, list.report).size() > list.entries.size()) std::abort();
  return 0;
}
