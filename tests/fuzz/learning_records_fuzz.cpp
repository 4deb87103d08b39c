#include <cstdlib>

#include "fuzz_target.h"
#include "motes/learning_records.h"

namespace rubicon::fuzz::learning_records_fuzz {

/// Input: a record type, then its bytes. What was decoded encodes to a record that decodes to the same (floats that are
/// no numbers are refused), but for the zeros that fill it up.
FUZZ_TARGET(learning_records) {
  if (size == 0) return 0;
  const ByteView bytes(data + 1, size - 1);
  const auto values = motes::decode_learning(data[0], bytes);
  const auto* record = motes::find_learning_record(data[0]);
  if (values && record == nullptr) std::abort();
  if (values) {
    const auto encoded = motes::encode_learning(record->name, *values);
    if (encoded) {
      if (encoded->size() != record->size) std::abort();
      const auto again = motes::decode_learning(data[0], *encoded);
      if (!again) std::abort();
      for (const auto& [name, numbers] : *values) {
        const auto& same = again->at(name);
        if (same.size() < numbers.size() || !std::equal(numbers.begin(), numbers.end(), same.begin())) std::abort();
      }
    } else if (encoded.error().text.find("floats is ") == std::string::npos) {
      std::abort();
    }
  }
  std::size_t left = bytes.size();
  const auto chunks = motes::matrix_chunks(bytes);
  for (const ByteView chunk : chunks) left -= chunk.size();
  if (left != 0 || chunks.back().size() == motes::kMatrixChunk) std::abort();
  return 0;
}

}  // namespace rubicon::fuzz::learning_records_fuzz
