#include "apps/simulators/motes/event.h"

#include <fmt/format.h>

namespace rubicon::motes_simulator {

std::string to_json(const Event& event) {
  auto line = fmt::format(R"({{"at":{:.6f},"event":"{}")", std::chrono::duration<double>(event.at).count(), event.what);
  if (event.sink != 0) line += fmt::format(R"(,"sink":{})", event.sink);
  if (event.mote != 0) line += fmt::format(R"(,"mote":{})", event.mote);
  if (event.sequence) line += fmt::format(R"(,"sequence":{})", *event.sequence);
  if (event.value) line += fmt::format(R"(,"value":{})", *event.value);
  if (!event.record.empty()) line += fmt::format(R"(,"record":"{}")", base::to_hex(event.record));
  return line + "}";
}

}  // namespace rubicon::motes_simulator
