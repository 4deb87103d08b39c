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
/// (wsn.md 9.8). kInvalid and kOutOfRange say what is wrong with tag or bytes; kRefused: it commands an actuator, past
/// the command desk.
Result<MoteRequest> opaque_request(std::uint16_t island, std::uint16_t mote, const model::Message& message,
                                   const MoteTag& tag);

/// A packet of another AM type for the sink itself, past the motes' network layer (wsn.md 7.2). kRefused for its
/// configuration and for the command of an actuator, kNotFound if it names a device, kOutOfRange for too many bytes.
Result<Bytes> am_packet(const model::Message& message, const MoteTag& tag);

/// What a mote acknowledges of what an application sent with a number of the application's own (wsn.md 7.2, matrix
/// upload); nullopt if it acknowledges a command of the firmware.
std::optional<model::Message> acknowledgement_for_applications(const motes::HeardAck& ack);

/// A mote's message of the learning or synaptic layer, as `mote/json`; nullopt if it is none.
std::optional<model::Opaque> as_json(const model::Opaque& message);

/// Whether a client's packet may be sent twice: the commands of the firmware itself may, what we do not know may not
/// (wsn.md 2).
bool may_repeat(const motes::DecodedPacket& packet);
/// What a client's packet tells a mote to read.
struct ReadOrder {
  std::uint16_t mote = 0;             ///< kBroadcast: all of them
  std::optional<std::uint16_t> mask;  ///< of the periodic command; nullopt: READ_UPDATES, which leaves that alone
};
/// nullopt if it tells nothing of the kind.
std::optional<ReadOrder> read_order_in(const motes::RadioMessage& message);
/// The same for a request of ours.
std::optional<ReadOrder> read_order_in(const MoteRequest& request);

/// The outcome of request `number` to a mote, in words for whoever asked.
model::Acknowledge acknowledge_of(std::uint64_t number, DeliveryResult how, std::uint16_t mote);

}  // namespace rubicon::networks::wsn
