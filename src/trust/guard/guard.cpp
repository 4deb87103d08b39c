#include "trust/guard/guard.h"

#include <algorithm>
#include <set>
#include <string>

#include "trust/guard/peers.h"
#include "trust/guard/watcher.h"

namespace rubicon::trust::guard {

namespace {

template <std::size_t size>
void put(char (&field)[size], const std::string& text) {
  const auto length = std::min(text.size(), size - 1);
  std::copy_n(text.begin(), length, field);
  field[length] = '\0';
}

}  // namespace

}  // namespace rubicon::trust::guard

namespace guard = rubicon::trust::guard;

extern "C" int rubicon_guard_version(void) noexcept {
  return RUBICON_GUARD_VERSION;
}

extern "C" int rubicon_guard_who(const uint8_t prefix[12], rubicon_guard_peer* peer) noexcept {
  guard::GuidPrefix wanted{};
  std::copy_n(prefix, wanted.size(), wanted.begin());
  const auto found = guard::peers().who(wanted);
  if (!found) return 0;
  guard::put(peer->name, found->name);
  guard::put(peer->roles, found->roles);
  guard::put(peer->ids, found->ids);
  guard::put(peer->serial, found->serial);
  peer->expires = found->expires;
  return 1;
}

extern "C" void rubicon_guard_revoke(const char* const* serials, size_t count) noexcept {
  std::set<std::string> revoked;
  for (std::size_t i = 0; i < count; ++i) {
    if (serials[i] != nullptr) revoked.insert(guard::plain_serial(serials[i]));
  }
  guard::peers().revoke(std::move(revoked));
}

extern "C" int rubicon_guard_meets_revoked(void) noexcept {
  return guard::peers().meets_revoked() ? 1 : 0;
}

extern "C" void rubicon_guard_watch(void (*call)(void* context, const uint8_t prefix[12], const char* name,
                                                 int is_verified, const char* reason),
                                    void* context) noexcept {
  guard::watch(call, context);
}
