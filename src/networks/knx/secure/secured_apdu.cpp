#include "networks/knx/secure/secured_apdu.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace rubicon::networks::knx::secure {

namespace {

constexpr std::uint8_t kTpciMask = 0xfc, kApciHigh = 0x03, kApciLow = 0xf1;
constexpr std::size_t kBeforeApdu = 9, kShortMac = 4, kSequenceSize = 6;
/// Address type and extended frame format in Ctrl2; the hop count between them changes on the way.
constexpr std::uint8_t kConstantControl2 = 0x8f;

/// B0 and C0 of a frame; `length` is that of the encrypted part.
Nonce nonce_of(const wire::DataFrame& frame, std::uint64_t sequence, std::size_t length) {
  Nonce nonce;
  for (std::size_t i = 0; i < kSequenceSize; ++i)
    nonce.b0[i] = static_cast<std::uint8_t>(sequence >> (8 * (kSequenceSize - 1 - i)) & 0xffU);
  const auto source = number(frame.source);
  nonce.b0[6] = static_cast<std::uint8_t>(source >> 8U);
  nonce.b0[7] = static_cast<std::uint8_t>(source & 0xffU);
  nonce.b0[8] = static_cast<std::uint8_t>(frame.destination >> 8U);
  nonce.b0[9] = static_cast<std::uint8_t>(frame.destination & 0xffU);
  nonce.c0 = nonce.b0;
  nonce.c0[14] = 0x01;
  nonce.b0[11] = frame.control2 & kConstantControl2;
  nonce.b0[12] = static_cast<std::uint8_t>((frame.tpdu[0] & kTpciMask) | kApciHigh);
  nonce.b0[13] = kApciLow;
  nonce.b0[15] = static_cast<std::uint8_t>(length);
  return nonce;
}

/// The first bytes of the MAC of an APDU that is authenticated only.
Result<Block> mac_of(Ccm& ccm, const Key& key, const Nonce& nonce, std::uint8_t control, ByteView apdu) {
  Bytes associated{control};
  associated.insert(associated.end(), apdu.begin(), apdu.end());
  return ccm.mac(key, nonce.b0, associated, {});
}

}  // namespace

bool is_secured(ByteView tpdu) {
  return tpdu.size() >= 2 && (tpdu[0] & kApciHigh) == kApciHigh && tpdu[1] == kApciLow;
}

Result<SecuredApdu> read_secured(ByteView tpdu) {
  if (tpdu.size() < kBeforeApdu + 2 + kShortMac)
    return fail(ErrorCode::kInvalid, fmt::format("secured telegram of {} bytes, expected at least {}", tpdu.size(),
                                                 kBeforeApdu + 2 + kShortMac));
  SecuredApdu out;
  out.control = tpdu[2];
  for (const auto byte : tpdu.subspan(3, kSequenceSize)) out.sequence = out.sequence << 8U | byte;
  out.apdu = tpdu.subspan(kBeforeApdu, tpdu.size() - kBeforeApdu - kShortMac);
  out.mac = tpdu.last(kShortMac);
  return out;
}

Result<Bytes> seal(Ccm& ccm, const Key& key, const wire::DataFrame& plain, std::uint8_t control,
                   std::uint64_t sequence) {
  const auto& tpdu = plain.tpdu;
  const bool encrypts = (control & control::kAlgorithm) != 0;
  const auto nonce = nonce_of(plain, sequence, encrypts ? tpdu.size() : 0);
  Bytes out{nonce.b0[12], kApciLow, control};
  out.reserve(kBeforeApdu + tpdu.size() + kShortMac);
  out.insert(out.end(), nonce.b0.begin(), nonce.b0.begin() + kSequenceSize);
  out.push_back(static_cast<std::uint8_t>(tpdu[0] & ~kTpciMask));
  out.insert(out.end(), tpdu.begin() + 1, tpdu.end());
  out.resize(out.size() + kShortMac);
  const auto apdu = std::span(out).subspan(kBeforeApdu, tpdu.size());
  const auto mac = std::span(out).last(kShortMac);
  if (encrypts) {
    if (auto done = ccm.seal(key, nonce, std::array{control}, apdu, mac); !done) return fail(done.error());
    return out;
  }
  const auto whole = mac_of(ccm, key, nonce, control, apdu);
  if (!whole) return fail(whole.error());
  std::copy_n(whole->begin(), kShortMac, mac.begin());
  return out;
}

Result<Bytes> open(Ccm& ccm, const Key& key, const wire::DataFrame& secured) {
  const auto parts = read_secured(secured.tpdu);
  if (!parts) return fail(parts.error());
  const auto algorithm = parts->control & control::kAlgorithm;
  if (algorithm != 0 && algorithm != control::kEncrypted)
    return fail(ErrorCode::kUnsupported, fmt::format("security algorithm {}", algorithm >> 4));
  const bool encrypted = algorithm != 0;
  const auto nonce = nonce_of(secured, parts->sequence, encrypted ? parts->apdu.size() : 0);
  Bytes plain(parts->apdu.begin(), parts->apdu.end());
  bool good = false;
  if (encrypted) {
    const auto opened = ccm.open(key, nonce, std::array{parts->control}, plain, parts->mac);
    if (!opened) return fail(opened.error());
    good = *opened;
  } else {
    const auto whole = mac_of(ccm, key, nonce, parts->control, plain);
    if (!whole) return fail(whole.error());
    good = equal(ByteView(*whole).first(kShortMac), parts->mac);
  }
  if (!good) return fail(ErrorCode::kRefused, "wrong MAC");
  plain[0] = static_cast<std::uint8_t>(plain[0] | (secured.tpdu[0] & kTpciMask));
  return plain;
}

Result<void> fits_secured(const wire::Telegram& telegram, std::size_t max_apdu) {
  const bool small = telegram.service == wire::Service::kRead || telegram.payload.small;
  const auto needed = 1 + (small ? 0 : telegram.payload.bytes.size()) + kSecurityBytes;
  if (needed <= max_apdu) return {};
  return fail(ErrorCode::kUnsupported,
              fmt::format("{} is secured: a value of {} bytes then needs {}, and the interface carries telegrams of at "
                          "most {} bytes: use another interface for this group",
                          to_string(telegram.destination), telegram.payload.bytes.size(), needed, max_apdu));
}

}  // namespace rubicon::networks::knx::secure
