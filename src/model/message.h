#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "base/bytes.h"
#include "model/point.h"
#include "rubicon/address.hpp"
#include "rubicon/result.hpp"
#include "rubicon/time.hpp"

namespace rubicon::model {

/// A device is there, with these capabilities (D1.4: RubiconMessageJoin). Repeated joins refresh; the list is complete.
struct Join {
  std::string device_type;  ///< a DeviceType's name, or empty
  std::string name;         ///< for people; empty = none
  std::string model;        ///< manufacturer and model; empty = unknown
  std::vector<Capability> capabilities;
  /// False when the device is known by configuration only and was not heard yet.
  bool heard = true;
  /// Key part its network wants for it (a recording brings the one it was recorded under); empty = made from the
  /// address. The configuration's id goes before.
  std::string id{};
  /// Why the device cannot be used (its interview failed); it then stands in the inbox and has no tuples. Empty =
  /// usable.
  std::string problem{};
  std::string area{};  ///< room or place, where the network knows it; empty = unknown
};

/// The device lives; nothing else to say.
struct KeepAlive {};

/// The network found that the device does not answer, before its silence ended. It stays listed; any sign of life ends
/// it.
struct Unreachable {
  std::string reason;
};

/// The device is gone for good and says so, or its network knows.
struct Leave {
  std::string reason;
};

struct Reading {
  PointId point;  ///< a sensor; also an actuator's or a property's state
  Value value;
  WallTime user_time{};  ///< when the device measured; zero = not known, the proxy publishes none
  std::string why{};     ///< of a reading without value: what is wrong; empty = the device has none
};

struct Updates {
  std::vector<Reading> readings;
  /// False: the network repeats values that it remembers of the device. They are shown as stored, and are no sign of
  /// life.
  bool heard = true;
};

/// Do this (D1.4: RubiconMessageCtrlActuateCmd). Answered with an Acknowledge of the same request.
struct Actuate {
  std::uint64_t request = 0;
  PointId point;
  Value value;
  /// A network that cannot send it at once gives it up after this time; 0 = its own rule.
  std::chrono::milliseconds time_to_live{0};
};

/// From now on report exactly these sensors (and actuators whose state is sampled), each at least every `period` (D1.4:
/// RubiconMessageCtrlPeriodicCmd). Empty = stop, or go as slow as the device allows.
struct Sample {
  std::uint64_t request = 0;
  std::vector<PointId> points;
  std::chrono::milliseconds period{0};
};

struct SetProperty {
  std::uint64_t request = 0;
  PointId point;
  Value value;
};

/// What became of a request. An acknowledgement of bus or firmware means sent, never more.
enum class Outcome : std::uint8_t { kSent, kFailed, kUnsupported, kUndeliverable, kRefused, kBusy };
std::string_view to_string(Outcome outcome);

struct Acknowledge {
  std::uint64_t request = 0;
  Outcome outcome = Outcome::kSent;
  std::string text;
};

/// Refused: the peer is there and does not take us; tried again, with pauses.
enum class LineState : std::uint8_t { kDown, kConnecting, kUp, kEnded, kRefused };
std::string_view to_string(LineState state);

/// How a network is: its line, its counters and what else it wants seen, as text or JSON (names are `[a-z-]+`). What a
/// later State does not name stays as it was. A network that tries to reach its peer again by itself counts its tries
/// as `attempts`, and says when the next one comes as `next-attempt` (seconds since 1970); the supervisor adds its own.
struct State {
  LineState line = LineState::kDown;
  std::string reason;
  std::map<std::string, std::uint64_t> counters;
  std::map<std::string, std::string> texts{};  ///< each at most 64 KiB
  std::string finding{};                       ///< of the reason, as Error has it
};

/// Application bytes with a type tag, never read on the way (D1.4: user object).
struct Opaque {
  std::string type;
  Bytes bytes;
};

/// Is the device still there? Asked of networks whose quiet devices can be probed; what answers is any sign of life. A
/// network that does not know the device learns of it what is remembered.
struct Probe {
  Join known;
};

using Body = std::variant<Join, KeepAlive, Leave, Updates, Actuate, Sample, SetProperty, Acknowledge, State, Opaque,
                          Probe, Unreachable>;

/// Index of a body's alternative: what listeners subscribe to.
enum class MessageKind : std::uint8_t {
  kJoin,
  kKeepAlive,
  kLeave,
  kUpdates,
  kActuate,
  kSample,
  kSetProperty,
  kAcknowledge,
  kState,
  kOpaque,
  kProbe,
  kUnreachable
};
std::string_view to_string(MessageKind kind);

/// Most islands a message may enter after its origin.
inline constexpr std::uint8_t kMaxHops = 4;

/// Who sent a message that other components may send: where the ecology knows members.
struct Sender {
  std::string name;
  std::vector<std::string> roles{};
  IslandId island = kNoOwner;  ///< the island that it is

  friend bool operator==(const Sender&, const Sender&) = default;
};

/// Most roles of a sender.
inline constexpr std::size_t kMaxRoles = 32;

/// What networks, gateways and listeners exchange (D1.4: RubiconMessage).
struct Message {
  IslandId origin = kNoOwner;  ///< the island it was born on; set by its gateway
  std::uint64_t number = 0;    ///< unique per origin for ever; set by its gateway; what makes delivery once
  std::uint8_t hops = 0;
  Address source;
  Address destination;
  Body body;
  /// Set by the first island that it entered, which relays it with this; absent = a component of this island sent it,
  /// or no members are known.
  std::optional<Sender> sender{};

  MessageKind kind() const { return static_cast<MessageKind>(body.index()); }
};

}  // namespace rubicon::model

namespace rubicon {

using model::Message;
using model::MessageKind;

}  // namespace rubicon

namespace rubicon::model {

/// Whether messages of this content type (Opaque::type) change an installation, as `zigbee.admin` does, and so need an
/// administrator: its name ends with `.admin`. The name shows it, because a program that checks rights does not have
/// the networks of other islands.
constexpr bool is_admin_type(std::string_view type) {
  return type.ends_with(".admin");
}

/// The media type of messages in GATEWAY tuples.
inline constexpr std::string_view kMessageMediaType = "application/rubicon+cbor";

/// True also for D1.4's spelling `rubicon/application` and the original's `application/rubicon`.
bool is_message_media_type(std::string_view media_type);

/// Largest encoded message and most entries in each of its lists.
inline constexpr std::size_t kMaxMessageBytes = 256UL * 1024;
inline constexpr std::size_t kMaxMessageEntries = 4096;

/// The CBOR form of docs/gateway.cddl. Types travel as number and, where the message has it, as name.
Bytes to_cbor(const Message& message);

/// kInvalid says which field is wrong and what was expected; kOutOfRange for a message beyond the bounds. Keys it does
/// not know are ignored, so that newer islands can say more.
Result<Message> from_cbor(ByteView bytes);

}  // namespace rubicon::model
