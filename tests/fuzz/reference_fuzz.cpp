#include <cstdlib>

#include "base/bytes.h"
#include "fuzz_target.h"
#include "tuples/meta_tuple.h"

namespace rubicon::fuzz::reference_fuzz {

/// Input: the value of a meta tuple, read in both spellings.
FUZZ_TARGET(reference) {
  using namespace rubicon;
  using namespace rubicon::tuples;
  const auto text = base::as_text({data, size});
  for (const auto media_type : {kReferenceMediaType, kPeisReferenceMediaType}) {
    const auto name = read_reference(media_type, text);
    if (!name) {
      if (name.error().text.empty()) std::abort();
      continue;
    }
    if (number(name->owner) == 0 || !model::check_key(name->key)) std::abort();
    const auto again = read_reference(kReferenceMediaType, to_string(*name));
    if (!again || *again != *name) std::abort();
  }
  return 0;
}

}  // namespace rubicon::fuzz::reference_fuzz
