#pragma once

#include <memory>
#include <string_view>

#include "base/log.h"
#include "base/scheduler.h"
#include "tuples/dds/dds_ecology.h"
#include "tuples/dds/dds_trust.h"

namespace rubicon::tuples::dds {

/// Brings the peers that were refused from the threads of DDS to the log, and counts them. They try again: one line for
/// each name, and kMaxLines lines for all, in a minute. Strangers may claim any name, so members have as many lines of
/// their own.
class Refusals {
 public:
  static constexpr int kMaxLines = 10;
  static constexpr std::size_t kMaxKnown = 4096;

  Refusals(Scheduler& scheduler, DdsEcology::Post post, base::LogSink& log);
  ~Refusals();
  Refusals(const Refusals&) = delete;
  Refusals& operator=(const Refusals&) = delete;

  /// From any thread.
  void take(const DdsTrust::Refusal& refusal);
  /// How many peers were refused. One that tries again is counted once, unless kMaxKnown others came in between.
  std::uint64_t peers() const;

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;
};

}  // namespace rubicon::tuples::dds
