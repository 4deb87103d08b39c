#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rubicon/address.hpp"
#include "rubicon/key.hpp"
#include "rubicon/point.hpp"
#include "rubicon/result.hpp"
#include "rubicon/summary.hpp"
#include "rubicon/time.hpp"
#include "rubicon/tuple_space.hpp"

/// What a program needs to take part in the tuple space of RUBICON islands (D1.4, chapter 2): docs/client.md.
namespace rubicon::client {

/// Where to meet the others; the defaults find islands with default configuration on this host.
struct Options {
  std::string name;              ///< for people, in lists of components; empty = `component`
  OwnerId id = model::kNoOwner;  ///< above 65535; kNoOwner = one is drawn
  std::uint32_t domain = 0;      ///< 0..230, as in the islands' `tuples.domain`
  std::vector<std::string> interfaces = {"lo"};
  std::vector<std::string> peers;  ///< host or host:port, of those that multicast does not reach
  bool tcp = false;                ///< as in the islands' `tuples.transport`; needs peers (host:port) or a port
  std::uint16_t port = 0;          ///< of TCP: where others may call; 0 = anywhere
  std::string tag;
  Duration lease = std::chrono::seconds(2);
  bool trust_lan = false;  ///< whether components of other hosts may set our tuples and send us messages
  std::function<void(std::string_view)> warn;  ///< told what goes wrong, at most once a minute and subject
};

/// A tuple of its own, where a TupleView would not live long enough.
struct Tuple {
  Tuple() = default;
  explicit Tuple(const tuples::TupleView& view);

  OwnerId owner{};
  std::string key, value, media_type;
  OwnerId creator{};
  std::uint64_t sequence = 0;
  WallTime write_time{}, user_time{}, expire_time{};
  bool owner_present = true;
};

/// One start of a component as it was met on the wire, also of those that are not talked to: other versions of the
/// protocol, ids that are taken twice.
struct Appearance {
  OwnerId id{};
  std::uint64_t incarnation = 0;  ///< microseconds since 1970 at its start, or later; of one id the highest counts
  unsigned version = 0;           ///< of the protocol
  bool present = false;
  Summary summary;
};

/// Another component that is present.
struct Component {
  OwnerId id{};
  Summary summary;  ///< empty until it said something of itself
};

/// A device as an island lists it.
struct Device {
  OwnerId island{};
  std::string prefix, network, id;  ///< its keys begin with <prefix>.<network>.<id>
  std::string name, model, type, address;
  std::string status;  ///< unknown, reachable or unreachable
  std::string reason;  ///< why
  WallTime since{};    ///< when the status became what it is
  LineStatus line;     ///< of its network
  std::vector<std::string> sensors, actuators, properties;
  std::string area;  ///< room or place; empty = not known

  /// `proxy.wsn-1.7`
  std::string key() const { return prefix + "." + network + "." + id; }
};

/// Which devices; empty = any, `*` and `?` as in shells. They must all hold.
struct DeviceQuery {
  std::optional<OwnerId> island{};
  std::string network;  ///< id of the network: `knx-hall`, `wsn*`
  std::string type;     ///< of the device, or of a sensor, actuator or property that it has: `EM1000`, `temperature`
  std::string name;     ///< for people, or the device's key part or address
  std::string area{};   ///< `Living*`
};

/// One sensor, actuator or property, with all that its island says of it: whether its value can be believed is part of
/// it. A tuple that is no point of an island has an empty quality.
struct Point {
  Tuple tuple;             ///< its `.value`
  PointStatus status;      ///< quality (docs/tuple-keys.md#quality), reason, heard, changed, last command
  LineStatus line;         ///< of its network
  std::string type, unit;  ///< `temperature`, `degC`; unit `1` for what has none

  const std::string& value() const { return tuple.value; }
  /// `proxy.wsn-1.7.sensor.light-1`
  std::string key() const { return tuple.key.substr(0, tuple.key.rfind('.')); }
  bool good() const { return status.quality == "good"; }
};

/// One point for each `.value` of a point among the tuples, in natural order of the keys, with what the other tuples
/// among them say of it: those that read() or a recording gave.
std::vector<Point> points_from(const std::vector<Tuple>& tuples);

/// What happened to a point.
enum class PointEvent : std::uint8_t {
  kValue,  ///< its value was set (equal values too)
  kState,  ///< its quality, the reason or the state of its line is another one; the value is as it was
  kGone,   ///< its tuple was deleted; or (`tuple.owner_present` is false) its island is lost for good
};

/// A network of an island, as `rubicon networks` shows it.
struct Network {
  OwnerId island{};
  std::string prefix, id;  ///< its keys begin with <prefix>.<id>
  LineStatus line;
  std::size_t devices = 0, reachable = 0;
  std::map<std::string, std::string> properties;  ///< counters and texts by name (docs/tuple-keys.md)

  /// `knx` of `knx-hall`
  std::string type() const { return id.substr(0, id.find('-')); }
};

/// How a command ended (docs/life-of-a-command.md).
struct Outcome {
  /// confirmed, assumed, refused, failed, timed-out, expired, superseded; applied (a tuple that has no status);
  /// no-such-owner. Under way: queued or sent.
  std::string state;
  std::string reason;         ///< why it ended so; under way: what it waits for
  std::uint64_t request = 0;  ///< with our id, names the command in the status
  WallTime until{};           ///< under way: when the state ends at the latest, by the island's clock; else zero
  bool good() const { return state == "confirmed" || state == "assumed" || state == "applied"; }
};

/// Bytes from one component to another through its GATEWAY tuple, never read on the way (D1.4: user object).
struct UserMessage {
  OwnerId from{};
  std::string type;  ///< the application's own word for what the bytes are
  std::string bytes;
  std::string network, device;  ///< who of its devices said it: address as the network spells it; empty = itself
};

using Ended = std::function<void(const Outcome&)>;
using TuplesCall = std::function<void(std::vector<Tuple>)>;
using PointsCall = std::function<void(std::vector<Point>)>;
using PointCall = std::function<void(PointEvent event, const Point& point)>;
using DeviceCall = std::function<void(const Device& device, bool present)>;
using MessageCall = std::function<void(const UserMessage&)>;
/// Empty text: the island took it.
using SentCall = std::function<void(const std::string& why_not)>;

/// A component of the tuple space with its own loop. Single-threaded: every call and callback on the thread that runs
/// the loop. Callbacks come from the loop only, never from inside a call; they may do anything but
/// destroy the client or wait: run(), run_until() and all that say that they wait.
///
/// The loop runs in run(), run_until() and the calls that say that they wait; or, in a program that has its own loop,
/// in poll(), whenever descriptor() is readable.
class Client final {
 public:
  /// kInvalid for unsound options, kBusy when this process has a client in that domain, kIo when the network does not
  /// work as the options say.
  static Result<std::unique_ptr<Client>> open(Options options = {});
  ~Client();
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  OwnerId id() const;
  /// Everything about tuples: own ones, subscriptions, copies, remote sets.
  TupleSpace& tuples();

  // -- the loop
  base::Scheduler& scheduler();  ///< for what needs to be handed one
  int descriptor() const;        ///< belongs to the client
  void poll();
  void run();   ///< until stop()
  void stop();  ///< may be called from a signal handler or another thread
  /// Runs the loop until `done` says true (asked after each turn) or the patience ends; what `done` said last.
  bool run_until(const std::function<bool()>& done, Duration patience);
  /// Once, after the delay.
  [[nodiscard]] Handle after(Duration delay, std::function<void()> call);

  // -- who is there
  std::vector<Component> components() const;  ///< all present ones, islands included, by id
  std::vector<Component> islands() const;
  /// Runs the loop until it has probably met everybody who is there: nobody new came for some 0.3 s.
  void meet();
  /// All starts met since this client came, bounded; for those who look for what is wrong.
  std::vector<Appearance> appearances() const;
  static unsigned protocol_version();

  // -- what there is
  /// All present tuples that match, once they are all here, without creating demand. Owners that answer nothing within
  /// the patience are left out.
  void read(const Pattern& pattern, TuplesCall call, Duration patience = std::chrono::seconds(3));
  /// The same, waits.
  std::vector<Tuple> read(const Pattern& pattern, Duration patience = std::chrono::seconds(3));
  /// All present points that match, with quality, reason and the state of their lines, without creating demand; in
  /// natural order of their keys. `points`: a key of five parts, `*` for any one (`proxy.*.*.sensor.temperature-1`);
  /// kInvalid for others. A point whose island left or was lost has quality network-down.
  Result<void> read_points(const Pattern& points, PointsCall call, Duration patience = std::chrono::seconds(3));
  /// The same, waits.
  Result<std::vector<Point>> read_points(const Pattern& points, Duration patience = std::chrono::seconds(3));
  /// Calls for each present point that matches, then for each set of a value at the pace of `flow`, and for each change
  /// of quality, reason or line though no value came. Creates demand for the values unless `flow` is passive. kInvalid
  /// as above, and network-down.
  Result<Handle> watch_points(const Pattern& points, const Flow& flow, PointCall call);
  /// The networks of all islands (or of one), by island and natural order of their ids; waits.
  std::vector<Network> networks(std::optional<OwnerId> island = {}, Duration patience = std::chrono::seconds(3));
  /// Calls for each device that fits, now and later, for each change of one, and (present = false) for each that went.
  [[nodiscard]] Handle watch_devices(const DeviceQuery& query, DeviceCall call);
  /// Those that are there now, the reachable ones first, then the unreachable, then those that were not heard yet;
  /// within by island, network and natural order of their ids. Waits.
  std::vector<Device> devices(const DeviceQuery& query = {}, Duration patience = std::chrono::seconds(3));

  // -- commands
  /// Sets a tuple of another component and follows what becomes of it: a `.command` to its final state, else to the
  /// owner's answer. `time_to_live` zero = 5 s; it always travels with the command. Waits as long as the island says
  /// that each state may last, and for the patience longer: then it is timed-out, and was not carried out meanwhile
  /// unless the island could not tell of it. `under_way` is called with each state that is not final.
  void command(OwnerId owner, std::string_view key, std::string_view value, Ended ended, Duration time_to_live = {},
               Duration patience = std::chrono::seconds(15), Ended under_way = {});
  /// The same, waits.
  Outcome command(OwnerId owner, std::string_view key, std::string_view value, Duration time_to_live = {},
                  Duration patience = std::chrono::seconds(15), Ended under_way = {});

  // -- messages
  /// In order, delivered once or `sent` says why not.
  void send(OwnerId to, std::string_view type, std::string_view bytes, SentCall sent = {});
  /// The same to a network of an island (`knx-hall`), for those types of network that listen (docs/knx.md).
  void send_to_network(OwnerId island, std::string_view network, std::string_view type, std::string_view bytes,
                       SentCall sent = {});
  /// The same to a device, by its address (`7`); without a network to the one that has it, refused where several have.
  void send_to_device(OwnerId island, std::string_view network, std::string_view address, std::string_view type,
                      std::string_view bytes, SentCall sent = {});
  /// Messages to this component of this type; empty = of all types.
  [[nodiscard]] Handle on_message(std::string_view type, MessageCall call);

 private:
  struct Impl;
  explicit Client(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace rubicon::client

namespace rubicon {
using client::Client;
}  // namespace rubicon
