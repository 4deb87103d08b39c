#include <cstdlib>
#include <string_view>

#include "fuzz_target.h"
#include "state/state_export.h"

namespace rubicon::fuzz::state_import_fuzz {

// Lines of an export: whatever is read is written again as something that reads as the same.
FUZZ_TARGET(state_import) {
  auto text = base::as_text({data, size});
  state::ExportReader reader;
  while (!text.empty()) {
    const auto end = std::min(text.find('\n'), text.size());
    const auto device = reader.line(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (!device || !*device) continue;
    const auto line = state::export_line(**device);
    state::ExportReader again;
    if (!again.line(state::export_head(*reader.island()))) std::abort();
    const auto back = again.line(line);
    if (!back || !*back || state::export_line(**back) != line) std::abort();
  }
  std::ignore = reader.end();
  return 0;
}

}  // namespace rubicon::fuzz::state_import_fuzz
