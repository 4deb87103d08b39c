#include "apps/rubicon/knx/bus.h"

#include "apps/rubicon/knx/direct_bus.h"

namespace rubicon::cli::knx {

std::unique_ptr<ToolLine> open_bus(const Settings& settings, const BusOptions& options, std::string_view command,
                                   int& code) {
  if (!options.direct.empty()) return open_direct(settings, options, code);
  return open_tool_line(settings, command, options.network, kBusTags, code);
}

}  // namespace rubicon::cli::knx
