#pragma once

#include "networks/knx/secure/group_guard.h"

namespace rubicon::networks::knx::line {

// The telegrams of a line through its guard of secured groups; without a guard they are written and read as they are.

/// The cEMI frame of a telegram that leaves from the address `own`.
inline Result<Bytes> encode(secure::GroupGuard* guard, wire::CemiCode code, const wire::Telegram& telegram,
                            wire::IndividualAddress own) {
  return guard != nullptr ? guard->protect(code, telegram, own) : wire::write_telegram(code, telegram);
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
