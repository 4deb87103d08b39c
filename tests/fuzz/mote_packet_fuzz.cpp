#include <cstdlib>

#include "fuzz_target.h"
#include "motes/mote_codec.h"

namespace rubicon::fuzz::mote_packet_fuzz {

namespace {

/// What was decoded must encode to the bytes it came from.
void check_round_trip(ByteView bytes) {
  const auto packet = motes::decode_packet(bytes);
  if (!packet) return;
  const Bytes again = motes::encode_packet(*packet);
  if (!std::equal(again.begin(), again.end(), bytes.begin(), bytes.end())) std::abort();
  const auto message = motes::decode_net(packet->payload);
  if (!message) return;
  const Bytes net = motes::encode_net(*message);
  if (!std::equal(net.begin(), net.end(), packet->payload.begin(), packet->payload.end())) std::abort();
  if (const auto record = motes::decode_record(*message); record && motes::encode_record(*record).empty()) std::abort();
}

}  // namespace

/// Input: one byte of settings, then packets, each after a length byte, through one codec.
FUZZ_TARGET(mote_packet) {
  static const TypeCatalogue types;
  if (size == 0) return 0;
  motes::Calibration calibration;
  calibration.board = static_cast<motes::Board>(data[0] % 5);
  calibration.units = (data[0] & 0x40) != 0 ? motes::Units::kRaw : motes::Units::kPhysical;
  const auto island = (data[0] & 0x80) != 0 ? std::optional<std::uint16_t>(11) : std::nullopt;
  motes::MoteCodec codec(types, {calibration, island});
  base::ByteReader reader({data + 1, size - 1});
  while (reader.remaining() > 0) {
    const std::size_t length = std::min<std::size_t>(reader.u8(), reader.remaining());
    const ByteView packet = reader.take(length);
    check_round_trip(packet);
    if (const auto events = codec.decode(packet); events) {
      for (const Message& message : events->messages) {
        const auto* updates = std::get_if<model::Updates>(&message.body);
        if (updates != nullptr && updates->readings.empty()) std::abort();
      }
    }
  }
  return 0;
}

}  // namespace rubicon::fuzz::mote_packet_fuzz
