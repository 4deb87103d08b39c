#pragma once

#include "base/bytes.h"
#include "rubicon/tuple.hpp"
#include "tuples/change.h"
#include "tuples/peis/wire.h"

namespace rubicon::tuples::peis {

// Messages between components of ours, on ports that kernels ignore: big-endian, in front the mark `RBC1`.

/// Port 41: request u64, sequence u64, verdict u8, error code u8, then the text.
Bytes write_reply(const Reply& reply);
/// kInvalid: too short, another mark, an unknown verdict or error code. The receiver is not in it.
Result<Reply> read_reply(ByteView body);

/// Port 43: kind u8 (1 end of a snapshot, 2 restart, 3 forget), 3 zero bytes, then subscription u32, or since u64
/// (microseconds), or nothing.
Bytes write_control(const SnapshotEnd& end);
Bytes write_control(const Restart& restart);
/// All subscriptions of the sender end; those that it has follow.
Bytes write_forget();
bool is_forget(ByteView body);
/// A SnapshotEnd or a Restart.
Result<Change> read_control(ByteView body);

}  // namespace rubicon::tuples::peis
