#include "trust/guard/watcher.h"

#include <mutex>

namespace rubicon::trust::guard {

namespace {

struct Watcher {
  std::mutex mutex;  ///< held while the call runs: whoever ends it knows that it runs no more
  void (*call)(void*, const std::uint8_t*, const char*, const char*) = nullptr;
  void* context = nullptr;
};

Watcher& watcher() {
  static Watcher one;
  return one;
}

}  // namespace

void watch(void (*call)(void* context, const std::uint8_t prefix[12], const char* name, const char* reason),
           void* context) {
  auto& one = watcher();
  const std::lock_guard lock(one.mutex);
  one.call = call;
  one.context = context;
}

void report(const GuidPrefix& prefix, const std::string& name, const std::string& reason) {
  auto& one = watcher();
  const std::lock_guard lock(one.mutex);
  if (one.call != nullptr) one.call(one.context, prefix.data(), name.c_str(), reason.c_str());
}

}  // namespace rubicon::trust::guard
