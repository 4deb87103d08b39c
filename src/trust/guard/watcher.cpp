#include "trust/guard/watcher.h"

#include <mutex>

namespace rubicon::trust::guard {

namespace {

struct Watcher {
  std::mutex mutex;  ///< held while the call runs: whoever ends it knows that it runs no more
  void (*call)(void*, const std::uint8_t*, const char*, int, const char*) = nullptr;
  void* context = nullptr;
};

Watcher& watcher() {
  static Watcher one;
  return one;
}

}  // namespace

void watch(void (*call)(void* context, const std::uint8_t prefix[12], const char* name, int is_verified,
                        const char* reason),
           void* context) {
  auto& one = watcher();
  const std::lock_guard lock(one.mutex);
  if (call == nullptr && context != one.context) return;
  one.call = call;
  one.context = context;
}

void report(const Refused& peer, const std::string& reason) {
  auto& one = watcher();
  const std::lock_guard lock(one.mutex);
  if (one.call != nullptr)
    one.call(one.context, peer.prefix.data(), peer.name.c_str(), peer.is_verified ? 1 : 0, reason.c_str());
}

}  // namespace rubicon::trust::guard
