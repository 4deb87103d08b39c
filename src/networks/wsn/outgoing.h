#pragma once

#include <cstdint>

#include "model/message.h"
#include "motes/mote_codec.h"
#include "networks/wsn/mote_requests.h"
#include "networks/wsn/mote_tag.h"

namespace rubicon::networks::wsn {

// Messages from this island to its motes, as requests whose `done` the caller sets.

/// An actuate command (wsn.md 7.1, 9.5). kNotFound: motes have no such actuator. kOutOfRange: the value is not a whole
/// number of 32 bits.
Result<MoteRequest> actuate_request(std::uint16_t island, std::uint16_t mote, std::string_view actuator_type,
                                    const model::Actuate& command);

/// A message that the mote acknowledges and otherwise ignores (wsn.md 9.3). One attempt.
MoteRequest probe_request(std::uint16_t island, std::uint16_t mote);

/// The acknowledgement of a mote's reliable message (wsn.md 9.6).
MoteRequest ack_request(std::uint16_t island, const motes::WantedAck& wanted);

/// An application message of this island, or of a component or mote of another one, whose address it then carries
/// (wsn.md 9.8). kInvalid and kOutOfRange for a faulty tag or record; kRefused: it commands an actuator, which only
/// tuples may do.
Result<MoteRequest> opaque_request(std::uint16_t island, std::uint16_t mote, const model::Message& message,
                                   const MoteTag& tag);

/// A packet of another AM type for the sink itself, outside the motes' network layer (wsn.md 7.2). kRefused: it
/// configures the sink or commands an actuator. kNotFound: it names a device. kOutOfRange: too many bytes.
Result<Bytes> am_packet(const model::Message& message, const MoteTag& tag);

/// A mote's acknowledgement of an application's message with the application's own sequence number (wsn.md 7.2, matrix
/// upload), as a message; nullopt if it acknowledges a command of the firmware.
std::optional<model::Message> acknowledgement_for_applications(const motes::HeardAck& ack);

/// A mote's message of the learning or synaptic layer as `mote/json`; nullopt for other messages.
std::optional<model::Opaque> as_json(const model::Opaque& message);

/// Whether a client's packet may be sent twice: only commands of the firmware may (wsn.md 2).
bool may_repeat(const motes::DecodedPacket& packet);

/// A command to a mote to read transducers.
struct ReadOrder {
  std::uint16_t mote = 0;             ///< kBroadcast: all motes
  std::optional<std::uint16_t> mask;  ///< of the periodic command; nullopt: READ_UPDATES, which does not change it
};
/// nullopt: the message is not such a command.
std::optional<ReadOrder> read_order_in(const motes::RadioMessage& message);
std::optional<ReadOrder> read_order_in(const MoteRequest& request);

/// The result of a message that needs no answer from a mote.
DeliveryResult delivery_result_of(sink::SendResult result);

/// The outcome of request `number` to a mote, with an explanation.
model::Acknowledge acknowledge_of(std::uint64_t number, DeliveryResult result, std::uint16_t mote);

}  // namespace rubicon::networks::wsn
