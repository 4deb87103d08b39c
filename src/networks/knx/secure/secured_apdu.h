#pragma once

#include <cstdint>

#include "networks/knx/secure/crypto.h"
#include "networks/knx/wire/cemi.h"

namespace rubicon::networks::knx::secure {

// Data Secure (KNX AN158, part of 3/3/7; knx.md, section 11). TPDU: TPCI and APCI 3F1, security control field, sequence
// number of 6 bytes, APDU, MAC of 4 bytes.

/// The security control field: b7 tool access, b6-4 algorithm, b3 system broadcast, b2-0 service.
namespace control {
inline constexpr std::uint8_t kAuthenticated = 0x00;  ///< data, authentication only
inline constexpr std::uint8_t kEncrypted = 0x10;      ///< data, authentication and encryption
inline constexpr std::uint8_t kToolAccess = 0x80, kAlgorithm = 0x70, kSystemBroadcast = 0x08, kService = 0x07;
inline constexpr std::uint8_t kSyncRequest = 2, kSyncResponse = 3;
}  // namespace control

constexpr std::uint64_t kMaxSequence = (std::uint64_t{1} << 48U) - 1;
/// What security adds to the length of an NPDU.
constexpr std::size_t kSecurityBytes = 13;

/// The parts of a secured TPDU. Refers to the bytes it was read from.
struct SecuredApdu {
  std::uint8_t control = control::kEncrypted;
  std::uint64_t sequence = 0;
  ByteView apdu;  ///< encrypted if the algorithm says so; at least 2 bytes
  ByteView mac;   ///< 4 bytes
};

/// True for a TPDU with the APCI of SecureService.
bool is_secured(ByteView tpdu);
/// kInvalid: too short.
Result<SecuredApdu> read_secured(ByteView tpdu);

/// The secured TPDU of a plain frame, whose source must be that of the telegram on the bus. `control`: kEncrypted or
/// kAuthenticated. Errors: those of OpenSSL.
Result<Bytes> seal(Ccm& ccm, const Key& key, const wire::DataFrame& plain, std::uint8_t control,
                   std::uint64_t sequence);
/// The plain TPDU of a secured frame. kRefused: the MAC is wrong; kUnsupported: another algorithm than those two;
/// kInvalid: too short.
Result<Bytes> open(Ccm& ccm, const Key& key, const wire::DataFrame& secured);

/// Refuses a telegram that an interface cannot carry once it is secured. `max_apdu`: of tunnelling feature 07 or DIB
/// 07, in bytes; 15 without extended frames, where only values of up to one byte fit. kUnsupported, with a sentence for
/// the user.
Result<void> fits_secured(const wire::Telegram& telegram, std::size_t max_apdu);

}  // namespace rubicon::networks::knx::secure
