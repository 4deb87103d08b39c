#pragma once

#include <dds/dds.h>

#include <cstddef>

#include "base/bytes.h"

namespace rubicon::tuples::dds {

/// Samples taken at a time, and frames processed in one turn of the loop.
inline constexpr std::uint32_t kSamples = 64;

/// Takes all samples of the reader, but not many more than `max`, and visits each, valid or not. Returns their number.
template <class Sample, class Visit>
std::size_t take(dds_entity_t reader, std::size_t max, Visit visit) {
  void* samples[kSamples] = {};
  dds_sample_info_t infos[kSamples];
  std::size_t total = 0;
  while (total < max) {
    const auto count = dds_take(reader, samples, infos, kSamples, kSamples);
    if (count <= 0) break;
    for (int i = 0; i < count; ++i) visit(*static_cast<const Sample*>(samples[i]), infos[i]);
    dds_return_loan(reader, samples, count);
    total += static_cast<std::size_t>(count);
  }
  return total;
}

}  // namespace rubicon::tuples::dds
