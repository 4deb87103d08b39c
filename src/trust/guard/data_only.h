#pragma once

struct ddsi_domaingv;

#ifdef __cplusplus
extern "C" {
#endif

/// Handshake messages have no key, but Cyclone DDS 0.10.2 takes a sample of them that says to be a key only, and then
/// reads the data that it lacks (handle_auth_handshake_message in ddsi_security_exchange.c). From now on this domain
/// drops such samples.
void rubicon_guard_take_data_only(struct ddsi_domaingv* domain);

#ifdef __cplusplus
}
#endif
