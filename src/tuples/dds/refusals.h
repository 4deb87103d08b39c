#pragma once

#include <memory>
#include <string_view>

#include "base/log.h"
#include "base/scheduler.h"
#include "tuples/dds/dds_ecology.h"
#include "tuples/dds/dds_trust.h"

namespace rubicon::tuples::dds {

/// Brings the peers that were refused from the threads of DDS to the log, and counts them. They try again once a second
/// and may claim any name: one line for each name, and kMaxLines lines for all, in a minute.
class Refusals {
 public:
  static constexpr int kMaxLines = 10;
  static constexpr std::size_t kMaxKnown = 4096;

  Refusals(Scheduler& scheduler, DdsEcology::Post post, base::LogSink& log);
  ~Refusals();
  Refusals(const Refusals&) = delete;
  Refusals& operator=(const Refusals&) = delete;

  /// From any thread. `name`: what its certificate claims; empty = it was not seen.
  void take(const GuidPrefix& peer, std::string_view name, std::string_view reason);
  /// How many peers were refused. One that tries again is counted once, unless kMaxKnown others came in between.
  std::uint64_t peers() const;

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;
};

}  // namespace rubicon::tuples::dds
