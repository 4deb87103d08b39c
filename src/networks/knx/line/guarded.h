#pragma once

#include <cstdint>
#include <optional>

#include "networks/knx/secure/group_guard.h"
#include "networks/knx/secure/secured_apdu.h"

namespace rubicon::networks::knx::line {

// The telegrams of a line through its guard of secured groups; without a guard they are written and read as they are.

/// The cEMI frame of a telegram that leaves from the address `own`. `max_apdu`: the longest secured APDU that the line
/// carries, in bytes; nullopt = not known. kUnsupported: the telegram is longer once it is secured.
inline Result<Bytes> encode(secure::GroupGuard* guard, wire::CemiCode code, const wire::Telegram& telegram,
                            wire::IndividualAddress own, std::optional<std::uint16_t> max_apdu = {}) {
  if (guard == nullptr) return wire::write_telegram(code, telegram);
  if (max_apdu && guard->secures(telegram.destination)) {
    if (auto fits = secure::fits_secured(telegram, *max_apdu); !fits) return fail(fits.error());
  }
  return guard->protect(code, telegram, own);
}

/// `own`: the present address of the line.
inline secure::GroupGuard::Opened decode(secure::GroupGuard* guard, const wire::DataFrame& frame,
                                         wire::IndividualAddress own) {
  if (guard != nullptr) return guard->open(frame, own);
  auto telegram = wire::to_telegram(frame);
  if (!telegram) return tl::unexpected<secure::GroupGuard::Dropped>(secure::GroupGuard::Dropped{});
  return std::move(*telegram);
}

}  // namespace rubicon::networks::knx::line
