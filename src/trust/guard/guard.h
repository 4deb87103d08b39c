#pragma once

/// The C interface of the guard (docs/trust.md): a library that Cyclone DDS loads as its three security plug-ins. It
/// wraps the built-in ones, closes the holes that they leave (decision 023), and knows who each peer is. A process asks
/// it by dlopen(path, RTLD_NOW | RTLD_NOLOAD) and dlsym. All functions are thread-safe and never throw.

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#define RUBICON_GUARD_NOEXCEPT noexcept
#else
#define RUBICON_GUARD_NOEXCEPT
#endif

#define RUBICON_GUARD_EXPORT __attribute__((visibility("default")))

/// Of the functions and structures below. Who loads the guard compares it with its own first.
#define RUBICON_GUARD_VERSION 1
RUBICON_GUARD_EXPORT int rubicon_guard_version(void) RUBICON_GUARD_NOEXCEPT;

/// A peer that authenticated itself.
struct rubicon_guard_peer {
  char name[65];    ///< CN of its subject
  char roles[257];  ///< separated by commas
  char ids[257];    ///< ranges of component ids as in the certificate: `00000007-00000007,01a00000-01afffff`
  char serial[65];  ///< upper-case hexadecimal digits, two for each byte, as `openssl x509 -serial` shows
  int64_t expires;  ///< seconds since 1970 UTC
};

/// 1 and fills `peer` if the participant with this GUID prefix is authenticated and not revoked; else 0.
RUBICON_GUARD_EXPORT int rubicon_guard_who(const uint8_t prefix[12],
                                           struct rubicon_guard_peer* peer) RUBICON_GUARD_NOEXCEPT;
/// Replaces the serials (zero-terminated, hexadecimal digits in either case, leading zeros do not count) that are
/// refused in handshakes and that rubicon_guard_who() no longer knows.
RUBICON_GUARD_EXPORT void rubicon_guard_revoke(const char* const* serials, size_t count) RUBICON_GUARD_NOEXCEPT;
/// 1 if a peer that authenticated itself is still here and was revoked since: it goes on reading what it has matched
/// until this process makes its DDS domain again.
RUBICON_GUARD_EXPORT int rubicon_guard_meets_revoked(void) RUBICON_GUARD_NOEXCEPT;
/// `call` runs on a thread of DDS after a handshake, or a writer or reader of a peer, was refused: the GUID prefix, the
/// name (may be empty) and the reason, both printable. If `is_verified` is 1, the name is that of a verified
/// certificate; else a certificate claims it, and a stranger may claim any. The next handshake of that peer comes after
/// a second, then after about twice as long each time, at most 5 s. DDS holds locks meanwhile: `call` may call
/// rubicon_guard_who(), but neither rubicon_guard_watch() nor DDS. It replaces the former call. nullptr ends the call
/// that was given with this context, if that has not been replaced; afterwards it runs no more.
RUBICON_GUARD_EXPORT void rubicon_guard_watch(void (*call)(void* context, const uint8_t prefix[12], const char* name,
                                                           int is_verified, const char* reason),
                                              void* context) RUBICON_GUARD_NOEXCEPT;

/// For the properties of a participant: `dds.sec.auth.library.path|init|finalize`, `dds.sec.access.library...`,
/// `dds.sec.crypto.library...`, where `path` is this library three times. As `plugin_init` and `plugin_finalize` of
/// dds/security/dds_security_api.h; 0 = done.
struct ddsi_domaingv;
RUBICON_GUARD_EXPORT int rubicon_guard_init_authentication(const char* argument, void** context,
                                                           struct ddsi_domaingv* domain) RUBICON_GUARD_NOEXCEPT;
RUBICON_GUARD_EXPORT int rubicon_guard_finalize_authentication(void* context) RUBICON_GUARD_NOEXCEPT;
RUBICON_GUARD_EXPORT int rubicon_guard_init_access_control(const char* argument, void** context,
                                                           struct ddsi_domaingv* domain) RUBICON_GUARD_NOEXCEPT;
RUBICON_GUARD_EXPORT int rubicon_guard_finalize_access_control(void* context) RUBICON_GUARD_NOEXCEPT;
RUBICON_GUARD_EXPORT int rubicon_guard_init_crypto(const char* argument, void** context,
                                                   struct ddsi_domaingv* domain) RUBICON_GUARD_NOEXCEPT;
RUBICON_GUARD_EXPORT int rubicon_guard_finalize_crypto(void* context) RUBICON_GUARD_NOEXCEPT;

#ifdef __cplusplus
}
#endif
