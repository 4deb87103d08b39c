#include <cstring>
#include <string>
#include <vector>

#include "trust/guard/guard.h"

// A guard without DDS: the test says who is there.

namespace {

rubicon_guard_peer known{};
std::vector<std::string> refused;
int version = RUBICON_GUARD_VERSION;
void (*watcher)(void*, const uint8_t*, const char*, int, const char*) = nullptr;
void* watched = nullptr;

bool is_refused(const char* serial) {
  for (const auto& one : refused) {
    if (one == serial) return true;
  }
  return false;
}

}  // namespace

extern "C" void fake_guard_set_version(int one) {
  version = one;
}

extern "C" int rubicon_guard_version(void) noexcept {
  return version;
}

extern "C" void fake_guard_know(const rubicon_guard_peer* peer) {
  known = *peer;
}

extern "C" int rubicon_guard_who(const uint8_t prefix[12], struct rubicon_guard_peer* peer) noexcept {
  if (prefix[0] != 1 || known.name[0] == '\0' || is_refused(known.serial)) return 0;
  *peer = known;
  return 1;
}

extern "C" void rubicon_guard_revoke(const char* const* serials, size_t count) noexcept {
  refused.assign(serials, serials + count);
}

extern "C" int rubicon_guard_meets_revoked(void) noexcept {
  return is_refused(known.serial) ? 1 : 0;
}

extern "C" void rubicon_guard_watch(void (*call)(void*, const uint8_t*, const char*, int, const char*),
                                    void* context) noexcept {
  if (call == nullptr && context != watched) return;
  watcher = call;
  watched = context;
}

/// A peer is refused.
extern "C" void fake_guard_refuse(const char* name, int is_verified, const char* reason) {
  const uint8_t prefix[12] = {1};
  if (watcher != nullptr) watcher(watched, prefix, name, is_verified, reason);
}
