#pragma once

#include <dds/dds.h>

#include <algorithm>

namespace rubicon::tuples::dds {

/// How long all that leave at a time wait for the acknowledgements of others: those that are cut off never answer, and
/// a program that ends has to be quick. Blocks the loop.
class Patience {
 public:
  static constexpr dds_duration_t kMax = DDS_MSECS(300);
  static constexpr dds_duration_t kRecovery = DDS_SECS(10);  ///< without a wait; then it is there again

  void await(dds_entity_t writer) {
    const auto begin = dds_time();
    if (begin - waited_ > kRecovery) left_ = kMax;
    dds_wait_for_acks(writer, left_);
    waited_ = dds_time();
    left_ = std::max<dds_duration_t>(left_ - (waited_ - begin), 0);
  }

 private:
  dds_duration_t left_ = kMax;
  dds_time_t waited_ = 0;
};

}  // namespace rubicon::tuples::dds
