#pragma once

#include <dds/dds.h>

#include <cstddef>

#include "base/bytes.h"

namespace rubicon::tuples::dds {

/// Samples taken at a time, and frames told in one turn of the loop.
inline constexpr std::uint32_t kSamples = 64;

/// Takes everything (or `most` samples) there is; each sample is told once, valid or not.
template <class Sample, class Tell>
std::size_t take(dds_entity_t reader, std::size_t most, Tell tell) {
  void* samples[kSamples] = {};
  dds_sample_info_t infos[kSamples];
  std::size_t total = 0;
  while (total < most) {
    const auto count = dds_take(reader, samples, infos, kSamples, kSamples);
    if (count <= 0) break;
    for (int i = 0; i < count; ++i) tell(*static_cast<const Sample*>(samples[i]), infos[i]);
    dds_return_loan(reader, samples, count);
    total += static_cast<std::size_t>(count);
  }
  return total;
}

}  // namespace rubicon::tuples::dds
