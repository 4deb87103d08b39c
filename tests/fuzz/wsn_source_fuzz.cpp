#include <cstdlib>

#include "base/bytes.h"
#include "fuzz_target.h"
#include "networks/wsn/sink/sink.h"

namespace rubicon::fuzz::wsn_source_fuzz {

/// A source string: it is parsed to an equal source from its own text, or the error has a text.
FUZZ_TARGET(wsn_source) {
  using namespace rubicon;
  using namespace rubicon::networks::wsn::sink;
  const auto source = parse_source(base::as_text(ByteView(data, size)));
  if (!source) {
    if (source.error().text.find("position") == std::string::npos) std::abort();
    return 0;
  }
  auto spelled = to_string(*source);
  if (!source->record.empty()) spelled += "+file@" + source->record;
  const auto again = parse_source(spelled);
  if (!again || *again != *source) std::abort();
  return 0;
}

}  // namespace rubicon::fuzz::wsn_source_fuzz
