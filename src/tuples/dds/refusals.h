#pragma once

#include <memory>
#include <string_view>

#include "base/log.h"
#include "base/scheduler.h"
#include "tuples/dds/dds_ecology.h"

namespace rubicon::tuples::dds {

/// Brings the peers that were refused from the threads of DDS to the log. They try again once a second and may claim
/// any name: one line for each name, and kMaxLines lines for all, in a minute.
class Refusals {
 public:
  static constexpr int kMaxLines = 10;

  Refusals(Scheduler& scheduler, DdsEcology::Post post, base::LogSink& log);
  ~Refusals();
  Refusals(const Refusals&) = delete;
  Refusals& operator=(const Refusals&) = delete;

  /// From any thread. `name`: what its certificate claims; empty = it was not seen.
  void take(std::string_view name, std::string_view reason);

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;
};

}  // namespace rubicon::tuples::dds
