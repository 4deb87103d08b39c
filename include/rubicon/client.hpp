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

/// The library for programs that take part in the tuple space of RUBICON islands (D1.4, chapter 2): docs/client.md.
namespace rubicon::client {

/// Engines that connect the components of an ecology, as in the islands' `tuples.engine` (docs/ecology.md).
enum class Engine : std::uint8_t { kDds, kPeis, kHost, kMqtt };

/// How a client takes part in a network of PEIS kernels, as in the islands' `tuples.peis`. Interfaces, lease and
/// trust_lan are those of Options.
struct PeisNetwork {
  std::string network = "default";   ///< components of other networks are not seen; 1 to 63 bytes
  std::uint16_t listen = 8000;       ///< the first free TCP port from here on is taken; 0 = any
  std::vector<std::string> connect;  ///< `tcp://HOST:PORT` of components to stay connected with, at most 64
  bool multicast = true;             ///< announce this host, and search for others
};

/// The MQTT broker at which components of several sites meet, as in the islands' `tuples.mqtt` (docs/sites.md).
struct Broker {
  std::string host;  ///< name or address; empty = none
  /// `HOST[:PORT]` of brokers that are used while those before are away, with the same user and TLS.
  std::vector<std::string> spare;
  std::uint16_t port = 0;         ///< 0 = 1883, with TLS 8883
  std::string space = "default";  ///< components of other spaces are not seen; 1 to 64 of `[0-9A-Za-z_.-]`
  std::string user, password;     ///< of a certificate the name (CN) in it; empty = without
  bool tls = false;
  std::string ca_file;                        ///< PEM; empty = the certificate authorities of the system
  std::string certificate_file, key_file;     ///< PEM, both or none
  std::string server_name;                    ///< expected in the certificate of the broker; empty = the host
  Duration lease = std::chrono::seconds(20);  ///< others lose this component after such a silence; at least 13 s
  bool all = false;  ///< meet all components from the beginning, not only those that are dealt with, or once discover()
  bool trust = false;  ///< take requests of others though the users of the broker may write in each other's names
};

/// How a client finds other components. The defaults find the islands of this host.
struct Options {
  std::string name;              ///< display name in lists of components; empty = `component`
  OwnerId id = model::kNoOwner;  ///< 65536 to 2^31-1; kNoOwner = a random one
  std::vector<Engine> engines;   ///< empty: host, DDS too if there are interfaces, MQTT if there is a broker
  /// For Engine::kHost, an absolute path: where the programs of this host meet (docs/host.md). Empty: RUBICON_FOLDER,
  /// else /run/rubicon where this user may enter it, else the user's own.
  std::string folder;
  std::string space;  ///< as in the islands' `tuples.space`: others are not seen; empty = RUBICON_SPACE, `default`
  Broker broker;      ///< for Engine::kMqtt
  PeisNetwork peis;   ///< for Engine::kPeis; domain, peers, tcp, port and tag are for kDds
  std::uint32_t domain = 0;             ///< 0..230, as in the islands' `tuples.domain`
  std::vector<std::string> interfaces;  ///< names of network interfaces, as in `tuples.interfaces`; empty = lo
  std::vector<std::string> peers;       ///< HOST or HOST:PORT of components that multicast does not reach
  bool tcp = false;                     ///< as in the islands' `tuples.transport`; needs a port, or peers with ports
  std::uint16_t port = 0;               ///< TCP port to listen on; 0 = any, so that only this component can connect
  std::string tag;                      ///< as in `tuples.tag`: components with another tag are not seen
  Duration lease = std::chrono::seconds(2);  ///< other components lose this one after such a silence
  bool trust_lan = false;  ///< components on other hosts may set tuples of this one and send messages to it
  /// Receives warnings, one per subject and minute.
  std::function<void(std::string_view)> warn;
};

/// A copy of a tuple that owns its texts; members as in TupleView.
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

/// One start (incarnation) of a component as observed by DDS, also of components that this one ignores because
/// of their protocol version or a duplicate id.
struct ComponentStart {
  OwnerId id{};
  std::uint64_t incarnation =
      0;                 ///< microseconds since 1970 at the start, or later; of several with one id the highest counts
  unsigned version = 0;  ///< protocol version
  bool present = false;
  Summary summary;
};

/// Another component that is present.
struct Component {
  OwnerId id{};
  Summary summary;  ///< empty if it published none
};

/// A program in a PEIS network with which this component cannot exchange tuples, or that this component cannot
/// identify.
struct PeisTrouble {
  enum class Kind : std::uint8_t {
    kForeignNetwork,  ///< it belongs to another network
    kForeignVersion,  ///< it speaks another version of the protocol
    kUnreachable,     ///< it was announced, routed to or configured, but no connection succeeds
    kOwnId,           ///< it uses the id of this component
    kSharedId,        ///< two programs use its id
  };
  Kind kind{};
  OwnerId id{};             ///< kNoOwner: not known
  std::string name;         ///< `tupleview@desk!4711`, or where to connect to; may be empty
  std::string detail;       ///< its network, the error of the last attempt, the other program, ...
  std::uint64_t times = 0;  ///< how often it was noticed
};

/// A PEIS network as one component sees it.
struct PeisView {
  /// Where this component listens for connections, `127.0.0.1:8000`; empty = it could not open a port.
  std::string local;
  std::size_t connections = 0;  ///< open ones
  std::vector<PeisTrouble> troubles;
  std::map<std::string, std::uint64_t> counters;  ///< what was not done since the start, by name; zeros are left out
};

/// Where the programs of this host meet, as one component sees it.
struct HostView {
  std::string folder, space;
  std::vector<std::string> awaited;  ///< programs that have not said who they are: `pid 812 of uid 1000`
};

/// A device as an island lists it.
struct Device {
  OwnerId island{};
  std::string prefix, network, id;  ///< its keys begin with `<prefix>.<network>.<id>.`
  std::string name, model, type, address;
  std::string status;                                       ///< unknown, reachable or unreachable
  std::string reason;                                       ///< of the status
  WallTime since{};                                         ///< start of the present status
  LineStatus line;                                          ///< of its network
  std::vector<std::string> sensors, actuators, properties;  ///< ids, `temperature-1`
  std::string area;                                         ///< room or place; empty = not known

  /// `proxy.wsn-1.7`
  std::string key() const { return prefix + "." + network + "." + id; }
};

/// Selects devices that match all members; an empty member matches any. `*` and `?` as in shells.
struct DeviceQuery {
  std::optional<OwnerId> island{};
  std::string network;  ///< id of the network: `knx-hall`, `wsn*`
  std::string type;     ///< of the device, or of a sensor, actuator or property that it has: `EM1000`, `temperature`
  std::string name;     ///< display name, key part or address of the device
  std::string area{};   ///< `Living*`
};

/// One sensor, actuator or property with its value, its quality and the state of its line. The quality tells whether
/// the value can be trusted; it is empty if the tuple is not a point of an island.
struct Point {
  Tuple tuple;             ///< its `.value` tuple
  PointStatus status;      ///< quality (docs/tuple-keys.md#quality), reason, times, last command
  LineStatus line;         ///< of its network
  std::string type, unit;  ///< `temperature`, `degC`; unit `1` = dimensionless
  /// Its values are events (a button, a scene): each one counts. The value is empty except for the 2 s after an
  /// event; `status.heard` says when the last one came.
  bool is_event = false;

  const std::string& value() const { return tuple.value; }
  /// `proxy.wsn-1.7.sensor.light-1`
  std::string key() const { return tuple.key.substr(0, tuple.key.rfind('.')); }
  bool good() const { return status.quality == "good" && !(is_event && tuple.value.empty()); }
};

/// Makes points of tuples, such as those that read() or a recording gives: one for each `.value` tuple of a point, with
/// its status from the other tuples, in natural order of the keys.
std::vector<Point> points_from(const std::vector<Tuple>& tuples);

/// A change of a point.
enum class PointEvent : std::uint8_t {
  kValue,    ///< its value was set, also to an equal value. That an event is over is not a change
  kState,    ///< its quality, the reason or the state of its line changed, not the value
  kRemoved,  ///< its tuple was deleted or, if `tuple.owner_present` is false, its island did not return
};

/// A network of an island, as `rubicon networks` shows it.
struct Network {
  OwnerId island{};
  std::string prefix, id;  ///< its keys begin with `<prefix>.<id>.`
  LineStatus line;
  std::size_t devices = 0, reachable = 0;         ///< number of devices, and of reachable ones
  std::map<std::string, std::string> properties;  ///< counters and texts by name (docs/tuple-keys.md)

  /// Network type: `knx` of the id `knx-hall`.
  std::string type() const { return id.substr(0, id.find('-')); }
};

/// State of a command (docs/life-of-a-command.md).
struct Outcome {
  /// Final: confirmed, assumed, refused, failed, timed-out, expired, superseded, applied (the tuple has no status),
  /// no-such-owner. Not final: queued, sent.
  std::string state;
  std::string reason;         ///< of a final state; before: what the command waits for
  std::uint64_t request = 0;  ///< number of the command, unique among those of this component
  WallTime until{};           ///< latest end of a state that is not final, by the island's clock; else zero
  bool good() const { return state == "confirmed" || state == "assumed" || state == "applied"; }
};

/// Application bytes that one component sends to another through its GATEWAY tuple; the proxies on the way do not
/// interpret them (D1.4: user object).
struct UserMessage {
  OwnerId from{};
  std::string type;  ///< content type, defined by the application
  std::string bytes;
  /// The device that sent it, in the notation of its network; empty = the component itself.
  std::string network, device;
};

using OutcomeCall = std::function<void(const Outcome&)>;
using TuplesCall = std::function<void(std::vector<Tuple>)>;
using PointsCall = std::function<void(std::vector<Point>)>;
using PointCall = std::function<void(PointEvent event, const Point& point)>;
using DeviceCall = std::function<void(const Device& device, bool present)>;
using MessageCall = std::function<void(const UserMessage&)>;
/// An empty error: the destination accepted the message.
using SentCall = std::function<void(const std::string& error)>;

/// A component of the tuple space with its own event loop. Not thread-safe: make all calls on the thread that runs the
/// loop. Callbacks run on that thread, from the loop, never inside a call. A callback must not destroy the client or
/// make a blocking call.
///
/// The loop runs during blocking calls: run(), run_until() and those marked "Blocks". A program with an event loop of
/// its own calls poll() instead whenever descriptor() is readable.
///
/// `timeout` bounds how long a call waits for components that do not answer. Time in which this process or its host was
/// stopped counts little, because this process could hear no component then.
class Client final {
 public:
  /// kInvalid for invalid options, kBusy if this process has a client in that DDS domain already, kIo if the network
  /// cannot be used as the options require.
  static Result<std::unique_ptr<Client>> open(Options options = {});
  ~Client();
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  OwnerId id() const;
  /// Own tuples, subscriptions, cached copies, remote sets. Lives as long as the client.
  TupleSpace& tuples();

  // -- the loop
  base::Scheduler& scheduler();  ///< for objects that need the scheduler of this loop
  int descriptor() const;        ///< owned by the client: do not close it
  void poll();                   ///< handles what is due, does not block
  void run();                    ///< until stop()
  void stop();                   ///< may be called from a signal handler or another thread
  /// Runs the loop until `done`, which is called after each turn, returns true, or until the timeout. Returns the last
  /// result of `done`.
  bool run_until(const std::function<bool()>& done, Duration timeout);
  /// Calls `call` once after the delay, unless the handle is destroyed first.
  [[nodiscard]] Handle after(Duration delay, std::function<void()> call);

  // -- components
  std::vector<Component> components() const;  ///< the components that are present, including islands, by id
  /// The islands among them: components with an id of an island whose summary names the prefix of its tuples.
  std::vector<Component> islands() const;
  /// Whether this component is present. nullopt: it has not been met, but may be there; on Engine::kHost alone that
  /// ends within milliseconds.
  std::optional<bool> has(OwnerId id) const;
  /// Blocks until all components of the host are known, at most for the patience; on DDS until no new one came for
  /// about 0.3 s; with PEIS for 0.7 s, after 2 s.
  void discover(Duration patience = std::chrono::seconds(3));
  /// Component starts observed since open(), bounded. For diagnostics.
  std::vector<ComponentStart> component_starts() const;
  /// Participants of the DDS domain that show no component to this one: they are no programs of Rubicon, or of a
  /// release that had certificates for DDS. For diagnostics.
  std::size_t silent_participants() const;
  static unsigned protocol_version();
  /// nullopt without Engine::kHost.
  std::optional<HostView> host_view() const;
  /// What this component sees of the PEIS network, for diagnostics. nullopt without Engine::kPeis.
  std::optional<PeisView> peis_view() const;

  // -- tuples, points, networks and devices
  /// Reads all present tuples that match, without creating demand. `call` receives them all at once; owners that do not
  /// answer within the timeout are left out; `warn` receives a line that names one of them.
  void read(const Pattern& pattern, TuplesCall call, Duration timeout = std::chrono::seconds(3));
  /// The same. Blocks.
  std::vector<Tuple> read(const Pattern& pattern, Duration timeout = std::chrono::seconds(3));
  /// Reads all present points that match, with their status, without creating demand, in natural order of the keys.
  /// The key of `points` has five parts, `*` for any (`proxy.*.*.sensor.temperature-1`); kInvalid for others. A point
  /// whose island left or was lost has the quality network-down.
  Result<void> read_points(const Pattern& points, PointsCall call, Duration timeout = std::chrono::seconds(3));
  /// The same. Blocks.
  Result<std::vector<Point>> read_points(const Pattern& points, Duration timeout = std::chrono::seconds(3));
  /// Reports each present point that matches, then each set of a value at the pace of `flow`, and each change of
  /// quality, reason or line state. Creates demand for the values unless `flow` is passive. Pattern, kInvalid and
  /// network-down as for read_points().
  Result<Handle> watch_points(const Pattern& points, const Flow& flow, PointCall call);
  /// The networks of all islands, or of one, by island and natural order of their ids. Blocks.
  std::vector<Network> networks(std::optional<OwnerId> island = {}, Duration timeout = std::chrono::seconds(3));
  /// Reports each device that matches, now and later, each change of one, and, with present = false, each one that is
  /// removed or whose island left.
  [[nodiscard]] Handle watch_devices(const DeviceQuery& query, DeviceCall call);
  /// The devices that match now: first the reachable ones, then the unreachable, then those not heard yet; each group
  /// by island, network and natural order of the ids. Blocks.
  std::vector<Device> devices(const DeviceQuery& query = {}, Duration timeout = std::chrono::seconds(3));

  // -- commands
  /// Sets a tuple of another component and tracks the result: of a `.command` tuple of a point until a final state, of
  /// others until the owner's reply. `time_to_live` (zero = 5 s) is sent with the command. `ended` receives the final
  /// state, `progress` each state before it. It ends as timed-out if no news comes for `timeout` after a state should
  /// have ended. Then it is not known whether the command was executed.
  void command(OwnerId owner, std::string_view key, std::string_view value, OutcomeCall ended,
               Duration time_to_live = {}, Duration timeout = std::chrono::seconds(15), OutcomeCall progress = {});
  /// The same. Blocks.
  Outcome command(OwnerId owner, std::string_view key, std::string_view value, Duration time_to_live = {},
                  Duration timeout = std::chrono::seconds(15), OutcomeCall progress = {});

  // -- messages
  /// Sends a message to a component. Messages arrive in order and at most once; `sent` reports the result.
  void send(OwnerId to, std::string_view type, std::string_view bytes, SentCall sent = {});
  /// Sends to a network of an island (`knx-hall`), if its type accepts messages (docs/knx.md).
  void send_to_network(OwnerId island, std::string_view network, std::string_view type, std::string_view bytes,
                       SentCall sent = {});
  /// Sends to a device, by its address (`7`). An empty network: the one that has the device; refused if several have.
  void send_to_device(OwnerId island, std::string_view network, std::string_view address, std::string_view type,
                      std::string_view bytes, SentCall sent = {});
  /// Receives the messages to this component of that type; an empty type = all messages.
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
