#pragma once

#include <atomic>
#include <functional>
#include <memory>

#include "tuples/dds/dds_ecology.h"
#include "tuples/dds/entity.h"

namespace rubicon::tuples::dds {

/// Wakes the loop from the threads of DDS: however many events there are, at most one posted call is pending.
class Signal {
 public:
  /// What has news. kWriter: a reader was matched, so that frames can be sent.
  enum Source : unsigned { kPresence = 1, kInterests = 2, kFrames = 4, kWriter = 8 };

  /// `call` receives the sources that raised the signal.
  Signal(DdsEcology::Post post, std::function<void(unsigned sources)> call);
  ~Signal();
  Signal(const Signal&) = delete;
  Signal& operator=(const Signal&) = delete;

  /// For entities that are deleted before the signal.
  const dds_listener_t* listener(Source source) const;
  void raise(Source source);
  /// What the listeners use, for entities that are deleted after the signal.
  std::shared_ptr<const void> used() const;

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;
};

}  // namespace rubicon::tuples::dds
