#include <cstddef>
#include <cstdint>

// A guard as the first ones were: without a version.

struct rubicon_guard_peer;

extern "C" int rubicon_guard_who(const uint8_t*, rubicon_guard_peer*) noexcept {
  return 0;
}

extern "C" void rubicon_guard_revoke(const char* const*, size_t) noexcept {}

extern "C" void rubicon_guard_watch(void (*)(void*, const uint8_t*, const char*, const char*), void*) noexcept {}
