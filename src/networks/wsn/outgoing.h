#pragma once

#include <cstdint>

#include "model/message.h"
#include "motes/mote_codec.h"
#include "networks/wsn/mote_requests.h"
#include "networks/wsn/mote_tag.h"

namespace rubicon::networks::wsn {

// What this island says to its motes, as requests whose `done` the caller fills in.

/// The actuate command (wsn.md 7.1, 9.5). kNotFound if the point is no actuator that motes have, kOutOfRange for a
/// value that is no whole number of 32 bits.
Result<MoteRequest> actuate_request(std::uint16_t island, std::uint16_t mote, std::string_view actuator_type,
                                    const model::Actuate& command);

/// Reliable and without a meaning: the mote acknowledges it and does nothing (wsn.md 9.3). One attempt.
MoteRequest probe_request(std::uint16_t island, std::uint16_t mote);

/// The acknowledgement of a mote's reliable message (wsn.md 9.6).
MoteRequest ack_request(std::uint16_t island, const motes::WantedAck& wanted);

/// An application message, of this island or another one's component or mote: that one's address goes with it
/// (wsn.md 9.8). kInvalid and kOutOfRange say what is wrong with tag or bytes.
Result<MoteRequest> opaque_request(std::uint16_t island, std::uint16_t mote, const model::Message& message,
                                   const MoteTag& tag);

/// A mote's message of the learning or synaptic layer, as `mote/json`; nullopt if it is none.
std::optional<model::Opaque> as_json(const model::Opaque& message);

/// Whether a client's packet may be sent twice: the commands of the firmware itself may, what we do not know may not
/// (wsn.md 2).
bool may_repeat(ByteView packet);
/// The mote that a client's packet tells what to read; nullopt if it does not.
std::optional<std::uint16_t> told_to_read(ByteView packet);

}  // namespace rubicon::networks::wsn
