#include <cstdlib>
#include <string_view>

#include "runtime/state_json.h"

using namespace rubicon;

// Lines of an export: whatever is read is written again as something that reads as the same.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  auto text = base::as_text({bytes, size});
  runtime::ExportReader reader;
  while (!text.empty()) {
    const auto end = std::min(text.find('\n'), text.size());
    const auto device = reader.line(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (!device || !*device) continue;
    const auto line = runtime::export_line(**device);
    runtime::ExportReader again;
    if (!again.line(runtime::export_head(*reader.island()))) std::abort();
    const auto back = again.line(line);
    if (!back || !*back || runtime::export_line(**back) != line) std::abort();
  }
  std::ignore = reader.end();
  return 0;
}
