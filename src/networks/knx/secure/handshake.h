#pragma once

#include <cstdint>

#include "networks/knx/secure/crypto.h"

namespace rubicon::networks::knx::secure {

/// The computations with which both ends of a session begin (knx.md, section 10.2; KNX 3/8/9).

/// The first 16 bytes of the SHA-256 of the shared secret.
Result<Key> session_key(const Secret& shared);

/// The MAC of SESSION_RESPONSE as transmitted. `device`: the device authentication code of the server.
Result<Block> response_mac(Ccm& ccm, const Key& device, std::uint16_t session, const PublicKey& client,
                           const PublicKey& server);

/// The MAC of SESSION_AUTHENTICATE as transmitted.
Result<Block> authenticate_mac(Ccm& ccm, const Key& user_key, std::uint8_t user, const PublicKey& client,
                               const PublicKey& server);

}  // namespace rubicon::networks::knx::secure
