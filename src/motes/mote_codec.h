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

/// An acknowledgement of a mote's application; its request has the same mote and sequence number (wsn.md 9.6).
struct HeardAck {
  std::uint16_t mote = 0;
  std::uint8_t application = 0;
  MoteAck ack;
};

/// A mote asks for an acknowledgement (wsn.md 9.6).
struct WantedAck {
  std::uint16_t mote = 0;
  std::uint8_t application = 0;
  std::uint16_t sequence = 0;
};

/// The content of one packet: messages for the host, and what the protocol itself needs.
struct MoteEvents {
  std::vector<model::Message> messages;
  std::optional<std::uint16_t> mote;  ///< the mote of our island that sent it
  bool joined = false;                ///< the mote was switched on, or repeated its join
  bool reported = false;              ///< the packet has readings
  std::optional<HeardAck> ack;
  /// The destination island, if it is not ours. A message of our mote is then in `messages` with its destination;
  /// otherwise the sink has another island id (wsn.md 9.1, 9.8).
  std::optional<std::uint16_t> foreign_island;
  /// The island of a foreign mote whose message our sink's radio received: ignored, because its own sink receives it.
  std::optional<std::uint16_t> foreign_source;
  std::optional<WantedAck> wants_ack;
};

/// Which fields of a mote's DEMO_DATA are measured values; the others contain stale memory (wsn.md 7.1, 9.4).
struct MeasuredFields {
  std::uint16_t sure = 0xffff;    ///< transducers
  std::uint16_t unless_zero = 0;  ///< further ones, unless the field is 0, as before the first measurement

  friend bool operator==(const MeasuredFields&, const MeasuredFields&) = default;
};

struct CodecOptions {
  Calibration calibration{};
  std::optional<std::uint16_t> island{};    ///< nullopt (recordings): every message counts as ours
  std::map<std::uint16_t, Board> boards{};  ///< of motes whose board differs from the calibration's
  bool actuators_report = false;            ///< whether motes report the state of their actuators
  /// For motes without set_measured(). The default takes all fields, as for recordings.
  MeasuredFields unknown{};
};

/// Decodes the packets of a sink into messages in terms of the catalogue. Remembers the sensors that each mote showed,
/// so that an undeclared sensor joins with its first reading (wsn.md 9.2), for at most kMaxMotes motes: for one that
/// joins beyond them, the one that was heard longest ago is forgotten, one that joined only if all did. Sets
/// source.device to the mote's address.
class MoteCodec {
 public:
  /// A sink has room for 20 (wsn.md 12); more addresses than this are noise.
  static constexpr std::size_t kMaxMotes = 1000;

  /// The catalogue must outlive the codec.
  MoteCodec(const TypeCatalogue& types, CodecOptions options);

  /// decode_whole() and interpret().
  Result<MoteEvents> decode(ByteView packet);
  /// The events in a packet. kInvalid if its source is not a mote, kBusy if it is one mote too many and does not join.
  Result<MoteEvents> interpret(const DecodedPacket& decoded);

  /// Restores a mote from its remembered join, until it joins again (wsn.md 9.2: it may never do so). Returns its
  /// present join if boards and units changed it, or if the mote was heard meanwhile.
  std::optional<model::Message> remember(std::uint16_t mote, const model::Join& join);
  /// Which fields of the mote's next reports are measured; nullopt: unknown.
  void set_measured(std::uint16_t mote, std::optional<MeasuredFields> fields);
  bool knows(std::uint16_t mote) const { return motes_.contains(mote); }
  /// Whether the mote declared or showed the point.
  bool offers(std::uint16_t mote, const model::PointId& point) const;
  /// The transducer of a sensor; 0 if unknown.
  std::uint16_t transducer_of(std::uint16_t mote, const model::PointId& sensor) const;
  /// Changes boards and units; returns the new joins of all motes.
  std::vector<model::Message> change(CodecOptions options);

 private:
  using Capabilities = std::vector<model::Capability>;
  using Shared = std::shared_ptr<const Capabilities>;
  static constexpr std::size_t kMaxKinds = 64;  ///< compared at a join
  struct Mote {
    std::optional<Joined> joined;  ///< its own declaration, or the remembered one
    std::uint64_t heard = 0;       ///< the number of its last message; 0 = none came
    std::string model;
    Shared declared = nothing();
    std::optional<MeasuredFields> fields;  ///< set_measured()
    Capabilities shown;                    ///< not declared, but read; kept when it joins again
    std::optional<double> celsius;
  };

  void on_record(const NetMessage& message, const Record& record, MoteEvents& events);
  void on_own_record(const NetMessage& message, const Record& record, MoteEvents& events);
  void on_joined(const Joined& joined, MoteEvents& events);
  void on_updates(std::uint16_t address, const RawUpdates& updates, MoteEvents& events);
  RawUpdates updates_of(std::uint16_t address, const DemoReport& demo) const;
  static const Shared& nothing();
  Shared shared(Capabilities capabilities);
  void declare(std::uint16_t address, Mote& mote);
  model::Capability actuator(std::string_view type) const;
  std::uint16_t mask_of(std::uint16_t mote, const model::Join& join) const;
  std::uint16_t transducer_under(const Calibration& calibration, const model::PointId& point) const;
  const Calibration& calibration(std::uint16_t mote) const;
  Mote& heard(std::uint16_t address);
  void forget_one();
  void sign_of_life(std::uint16_t address, MoteEvents& events);
  void report_join(std::uint16_t address, const Mote& mote, MoteEvents& events) const;
  model::Message join_of(std::uint16_t address, const Mote& mote) const;
  bool show(Mote& mote, const MoteSensor& sensor) const;
  model::Capability capability_of(const MoteSensor& sensor) const;
  model::PointId point_of(Kind kind, std::string_view type, std::string instance) const;

  const TypeCatalogue& types_;
  CodecOptions options_;
  std::map<std::uint16_t, Calibration> exceptions_;  ///< by mote
  std::map<std::uint16_t, Mote> motes_;
  std::uint64_t last_heard_ = 0;                          ///< the number of the last message of a mote
  std::vector<std::weak_ptr<const Capabilities>> kinds_;  ///< shared between motes that declare the same
};

}  // namespace rubicon::motes
