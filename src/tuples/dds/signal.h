#pragma once

#include <atomic>
#include <functional>
#include <memory>

#include "tuples/dds/dds_ecology.h"
#include "tuples/dds/entity.h"

namespace rubicon::tuples::dds {

/// How the threads of DDS wake the loop: however much happens, one posted call until it ran.
class Signal {
 public:
  Signal(DdsEcology::Post post, std::function<void()> call);
  ~Signal();
  Signal(const Signal&) = delete;
  Signal& operator=(const Signal&) = delete;

  /// Set on entities that must be deleted before the signal.
  const dds_listener_t* listener() const { return listener_.get(); }
  void raise();

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;
  DdsListener listener_;
};

}  // namespace rubicon::tuples::dds
