#include <cstdlib>

#include "fuzz_target.h"
#include "tuples/host/connection.h"

namespace rubicon::fuzz::host_record_fuzz {

/// Input: one record without its size. What was understood must be written and read alike.
FUZZ_TARGET(host_record) {
  using namespace rubicon::tuples::host;
  const auto record = read_record({data, size});
  if (!record) return 0;
  Bytes out;
  append(out, *record);
  const auto again = read_record(ByteView(out).subspan(kSizeBytes));
  if (!again || again->type != record->type || again->id != record->id || again->target != record->target ||
      again->number != record->number || again->text != record->text ||
      base::as_text(again->content) != base::as_text(record->content))
    std::abort();
  return 0;
}

}  // namespace rubicon::fuzz::host_record_fuzz
