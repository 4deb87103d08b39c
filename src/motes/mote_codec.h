#pragma once

#include <cstdint>
#include <map>
#include <memory>
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

/// The sender wants an acknowledgement (wsn.md 9.6).
struct WantedAck {
  std::uint16_t mote = 0;
  std::uint8_t application = 0;
  std::uint16_t sequence = 0;
};

/// What one packet says: messages for the host, and the protocol's own part.
struct MoteEvents {
  std::vector<model::Message> messages;
  std::optional<std::uint16_t> mote;  ///< of our island, that lives
  bool joined = false;                ///< it was switched on, or told the sink so again
  bool reported = false;              ///< it sends readings
  std::optional<HeardAck> ack;
  /// The island the message was for, where that is not ours: `messages` has it with its destination if it comes from a
  /// mote of ours; else the sink has another id (wsn.md 9.1, 9.8).
  std::optional<std::uint16_t> foreign_island;
  /// The island of a mote that is not ours and speaks to us over our own sink's radio: not taken, its own sink hears
  /// it.
  std::optional<std::uint16_t> foreign_source;
  std::optional<WantedAck> wants_ack;
};

/// Which fields of a mote's DEMO_DATA are measured values; the others hold old memory (wsn.md 7.1, 9.4).
struct MeasuredFields {
  std::uint16_t sure = 0xffff;    ///< transducers
  std::uint16_t unless_zero = 0;  ///< further ones where the field is not 0, which it is until the first measurement

  friend bool operator==(const MeasuredFields&, const MeasuredFields&) = default;
};

struct CodecOptions {
  Calibration calibration{};
  std::optional<std::uint16_t> island{};    ///< none (recordings): every message counts as ours
  std::map<std::uint16_t, Board> boards{};  ///< of motes that are built otherwise than the calibration says
  bool actuators_report = false;            ///< whether the motes tell what their actuators are at
  /// Of motes of which nobody said what they measure. The default takes all fields, as a recording has them.
  MeasuredFields unknown{};
};

/// Packets from a sink -> messages in the catalogue's words. Remembers what each mote showed, so that a sensor nobody
/// declared joins with its first reading (wsn.md 9.2); at most kMostMotes of them. Fills source.device with the mote's
/// address.
class MoteCodec {
 public:
  /// A sink has room for 20 (wsn.md 12); more addresses than this come from noise.
  static constexpr std::size_t kMostMotes = 1000;

  /// The catalogue must outlive the codec. More than kMostMotes motes are kBusy.
  MoteCodec(const TypeCatalogue& types, CodecOptions options);

  /// decode_whole() and interpret().
  Result<MoteEvents> decode(ByteView packet);
  /// What a packet means. kInvalid for a message that no mote can have sent.
  Result<MoteEvents> interpret(const DecodedPacket& decoded);

  /// What is remembered of a mote that did not join since (wsn.md 9.2: it may never do so again). If that is not what
  /// it is by our boards and units, or it was heard meanwhile: its join, as it is now.
  std::optional<model::Message> know(std::uint16_t mote, const model::Join& join);
  /// What the mote measured of its next reports; nullopt = nobody knows.
  void measures(std::uint16_t mote, std::optional<MeasuredFields> fields);
  bool knows(std::uint16_t mote) const { return motes_.contains(mote); }
  /// Whether the mote declared the point, or showed it.
  bool offers(std::uint16_t mote, const model::PointId& point) const;
  /// The transducer behind a sensor; 0 if there is none of that kind.
  std::uint16_t transducer_of(std::uint16_t mote, const model::PointId& sensor) const;
  /// Other boards and units from now on; the joins of all motes, as they are then.
  std::vector<model::Message> change(CodecOptions options);

 private:
  using Capabilities = std::vector<model::Capability>;
  using Shared = std::shared_ptr<const Capabilities>;
  static constexpr std::size_t kMostKinds = 64;  ///< that are looked through at a join
  struct Mote {
    std::optional<Joined> joined;  ///< what it said of itself, or is remembered of it
    bool heard = false;
    std::string model;
    Shared declared = nothing();
    std::optional<MeasuredFields> fields;  ///< measures()
    Capabilities shown;                    ///< not declared, but read: they outlive a re-join
    std::optional<double> celsius;
  };

  void on_record(const NetMessage& message, const Record& record, MoteEvents& events);
  void on_own_record(const NetMessage& message, const Record& record, MoteEvents& events);
  void on_joined(const Joined& joined, MoteEvents& events);
  void on_updates(std::uint16_t address, const RawUpdates& updates, MoteEvents& events);
  RawUpdates updates_of(std::uint16_t address, const DemoReport& demo) const;
  static const Shared& nothing();
  Shared once(Capabilities made);
  void declare(std::uint16_t address, Mote& mote);
  model::Capability actuator(std::string_view type) const;
  std::uint16_t mask_of(std::uint16_t mote, const model::Join& join) const;
  std::uint16_t transducer_under(const Calibration& calibration, const model::PointId& point) const;
  const Calibration& calibration(std::uint16_t mote) const;
  void heard(std::uint16_t address, MoteEvents& events);
  void tell_join(std::uint16_t address, const Mote& mote, MoteEvents& events) const;
  model::Message join_of(std::uint16_t address, const Mote& mote) const;
  bool show(Mote& mote, const MoteSensor& sensor) const;
  model::Capability capability_of(const MoteSensor& sensor) const;
  model::PointId point_of(Kind kind, std::string_view type, std::string instance) const;

  const TypeCatalogue& types_;
  CodecOptions options_;
  std::map<std::uint16_t, Calibration> exceptions_;  ///< by mote
  std::map<std::uint16_t, Mote> motes_;
  std::vector<std::weak_ptr<const Capabilities>> kinds_;  ///< what motes declare, each kind of them once
};

}  // namespace rubicon::motes
