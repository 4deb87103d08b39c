#pragma once

#include <string>

#include "base/bytes.h"
#include "networks/knx/wire/address.h"

namespace rubicon::networks::knx::wire {

/// A cEMI frame as readable text in one line: `L_Data.ind low from 1.1.201 to 1/2/5 hops 5 GroupValueResponse (small)
/// 01`. Frames that cannot be read are given in hex with the reason. Never fails.
std::string describe(ByteView cemi, Notation notation = Notation::kThreeLevel);

}  // namespace rubicon::networks::knx::wire
