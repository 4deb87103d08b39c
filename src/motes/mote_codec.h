#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "model/message.h"
#include "model/type_catalogue.h"
#include "motes/mote_records.h"
#include "motes/mote_units.h"

namespace rubicon::motes {

/// An application acknowledgement, for whoever waits for one: matches on mote and sequence number (wsn.md 9.6).
struct HeardAck {
  std::uint16_t mote = 0;
  std::uint8_t application = 0;
  MoteAck ack;
};

/// What one packet says: messages for the host, and the protocol's own part.
struct MoteEvents {
  std::vector<model::Message> messages;
  std::optional<HeardAck> ack;
  /// The island the message was for, where that is not ours: the sink has another id, or the message is to be routed.
  std::optional<std::uint16_t> foreign_island;
  /// The sender wants an acknowledgement of this sequence number (wsn.md 9.6).
  std::optional<std::uint16_t> wants_ack;
};

/// Packets from a sink -> messages in the catalogue's words. Remembers what each mote showed, so that a sensor nobody
/// declared joins with its first reading (wsn.md 9.2); at most 65533 motes. Fills source.device with the mote's
/// address.
class MoteCodec {
 public:
  /// Without an island (recordings) every message counts as ours. The catalogue must outlive the codec.
  MoteCodec(const TypeCatalogue& types, Calibration calibration, std::optional<std::uint16_t> island = std::nullopt);

  Result<MoteEvents> decode(ByteView packet);

 private:
  struct Mote {
    std::string model;
    std::vector<model::Capability> declared;
    std::vector<model::Capability> shown;  ///< not declared, but read: they outlive a re-join
    std::optional<double> celsius;
  };

  void on_record(const NetMessage& message, const Record& record, MoteEvents& events);
  void on_joined(const Joined& joined, MoteEvents& events);
  void on_updates(std::uint16_t address, const RawUpdates& updates, MoteEvents& events);
  void heard(std::uint16_t address, MoteEvents& events);
  void tell_join(std::uint16_t address, const Mote& mote, MoteEvents& events) const;
  bool show(Mote& mote, const MoteSensor& sensor) const;
  model::Capability capability_of(const MoteSensor& sensor) const;
  model::PointId point_of(Kind kind, std::string_view type, std::string instance) const;

  const TypeCatalogue& types_;
  Calibration calibration_;
  std::optional<std::uint16_t> island_;
  std::map<std::uint16_t, Mote> motes_;
};

}  // namespace rubicon::motes
