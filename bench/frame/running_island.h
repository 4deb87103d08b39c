#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "base/log.h"
#include "island/island.h"
#include "tuples/dds/dds_ecology.h"

namespace rubicon::bench {

/// A log whose lines are discarded.
base::NullLogSink& nowhere();

/// Throws if a call failed that the measurement needs.
void must(const Result<void>& result);
template <class T>
T must(Result<T> result) {
  must(result ? Result<void>() : Result<void>(fail(result.error())));
  return std::move(*result);
}

/// A running island. Its parts must outlive it.
std::unique_ptr<island::Island> start_island(const std::string& yaml, Scheduler& scheduler,
                                             transport::Transports& transports, tuples::Ecology& ecology,
                                             std::unique_ptr<state::StateStore> state = nullptr);

/// A component other than an island.
class Component {
 public:
  Component(tuples::Ecology& ecology, Scheduler& scheduler, std::uint32_t id);
  TupleSpace& operator*() { return *space_; }
  TupleSpace* operator->() { return space_.get(); }

 private:
  std::unique_ptr<tuples::Link> link_;
  std::unique_ptr<TupleSpace> space_;
};

/// The tuple space of the processes on this host that use this DDS domain. The scheduler must accept calls from other
/// threads.
std::unique_ptr<tuples::dds::DdsEcology> join_on_loopback(std::uint32_t domain, Scheduler& scheduler);

}  // namespace rubicon::bench
