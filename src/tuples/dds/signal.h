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
  /// What there is news of. A writer's news is that somebody can be reached.
  enum Source : unsigned { kPresence = 1, kInterests = 2, kFrames = 4, kWriter = 8 };

  /// `call` is told the sources that raised it.
  Signal(DdsEcology::Post post, std::function<void(unsigned sources)> call);
  ~Signal();
  Signal(const Signal&) = delete;
  Signal& operator=(const Signal&) = delete;

  /// Of entities that must be deleted before the signal.
  const dds_listener_t* listener(Source source) const;
  void raise(Source source);

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;
};

}  // namespace rubicon::tuples::dds
