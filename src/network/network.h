#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/bytes.h"
#include "base/config_reader.h"
#include "base/log.h"
#include "base/scheduler.h"
#include "model/message.h"
#include "model/point_tuples.h"
#include "model/type_catalogue.h"
#include "rubicon/result.hpp"
#include "transport/transports.h"

namespace rubicon::network {

/// Bounds of what a network remembers.
inline constexpr std::size_t kMaxMemoryName = 64, kMaxMemoryValue = 4096, kMaxMemories = 4096;

/// When a remembered value is on the disk.
enum class Keep : std::uint8_t {
  kNow,  ///< when remember() returns
  kSoon  ///< with the next kNow of any network, or later: it survives the end of the process, and costs no wait
};

/// kOutOfRange, with the reason, unless a network may remember this value under this name.
Result<void> check_memory(std::string_view name, ByteView value);

/// Keeps a tuple subscription alive; destroying it unsubscribes.
using TupleWatch = std::shared_ptr<void>;

/// What a network may use of the island. Owned by the supervisor, outlives the network.
class NetworkHost {
 public:
  virtual ~NetworkHost() = default;

  /// Sends a message upwards: Join, KeepAlive, Unreachable, Leave, Updates, Acknowledge, State, Opaque. Fill
  /// source.device and body (and the destination if it is not this island); the host fills in the rest. Only queues;
  /// may be called at any time after the construction of the network.
  virtual void deliver(Message&& message) = 0;
  /// The line is lost; the host calls open() again after a pause. Messages that wait for the line may stay in the
  /// network.
  virtual void failed(Error why) = 0;

  /// Subscribes to a tuple for a network that shows values to its devices. `tuple` is the key of a tuple of this
  /// island, or `ID:key` for one of another component. `call` gets the present value in a later turn, then each new one
  /// (empty: the tuple was deleted), until the result is destroyed. Not to be called while the network is constructed.
  /// kInvalid if `tuple` names no tuple. The default has no tuples: kUnsupported.
  virtual Result<TupleWatch> watch_tuple(std::string_view tuple, std::function<void(std::string_view value)> call);

  /// Keeps a small value of the network under a name of `[a-z0-9.-]`, also after the process ends; an empty one removes
  /// it. Keep::kNow waits for the disk, so not to be called often. Not to be called while the network is constructed.
  /// kUnsupported: the island has no state file (the default); kRefused: it can only be read; kOutOfRange: a name of
  /// more than kMaxMemoryName bytes or other characters, a value of more than kMaxMemoryValue bytes; kBusy: the network
  /// has kMaxMemories values, or the file is at its limit; else kIo.
  virtual Result<void> remember(std::string_view name, ByteView value, Keep keep);
  /// The stored value; nullopt: there is none. kUnsupported: the island has no state file (the default); else an error
  /// if the file cannot be read.
  virtual Result<std::optional<Bytes>> remembered(std::string_view name);

  virtual Scheduler& scheduler() = 0;
  virtual transport::Transports& transports() = 0;
  virtual const Log& log() const = 0;

  /// Delivers `body` from `device` to the gateway of this island.
  void deliver(std::string device, model::Body body);
  /// The same log for events that outsiders can cause often: one line per subject and minute.
  base::LimitedLog limited_log() { return {log(), scheduler()}; }
};

/// What a network is made from. `options` is the network's map. The caller reads the keys that all networks share
/// (type, silence, devices, ...); the network reads every other key, and the caller reports the unknown ones.
struct NetworkConfig {
  std::string id;  ///< `wsn-1`
  IslandId island{};
  ConfigReader& options;
  const TypeCatalogue& types;
  std::string directory;  ///< of the configuration file: relative paths start here; empty = the working directory
  /// Parses further YAML files that options name (`file` appears in errors); nullptr where there is no parser.
  Result<ConfigNode> (*read_yaml)(std::string_view text, std::string_view file) = nullptr;
  std::size_t most_devices = 20000;  ///< `limits.devices` of the island
  bool remembers = false;            ///< the island has a state file: NetworkHost::remember
  bool closed = false;  ///< only members reach the island (docs/trust.md): nothing is open to other programs by default
};

/// A device that the options name, with all its points.
struct ListedDevice {
  std::string address;
  std::vector<model::Capability> capabilities;
};

/// A property of the network itself that users may set (`<network>.property.<name>.command`). Its value is the text
/// that the network reports under the same name in its State.
struct Control {
  std::string name;  ///< `[a-z-]+`
  model::PointDescription description;
};

/// What an option names and this host does not have: a file, an interface.
struct Missing {
  enum class Kind : std::uint8_t {
    kOnHost,  ///< an error on this host only
    kWrong,   ///< wrong on each host, as the files of the configuration show: a reload refuses it
    kWarning  ///< the network works without it, but does less
  };
  std::string option;
  std::string text;
  Kind kind = Kind::kOnHost;
};

/// How long all networks of an island together may send last messages to their devices when the island ends.
inline constexpr Duration kClosingTime = std::chrono::seconds(2);

/// A network of devices behind one line. Destruction stops it at once; the host is not called again.
class Network {
 public:
  virtual ~Network() = default;
  /// Opens the line; called again after each failed(). Never blocks: success may be announced later by State{kUp}. An
  /// error counts as failed().
  virtual Result<void> open() = 0;
  /// Sends a message downwards: Actuate, Sample, SetProperty, Opaque, Probe; the destination is a device of this
  /// network. Every request is answered, either by the error returned here (kUnsupported is a valid answer), or by a
  /// later Acknowledge with the request's number.
  virtual Result<void> send(const Message& message) = 0;
  /// A user wants the next attempt now: ends a pause that the network makes by itself (after a refusal of its peer) and
  /// tries in a later turn. Called only while the line is not up and the host plans no attempt. The default makes no
  /// pauses of its own: kUnsupported.
  virtual Result<void> reopen();
  /// Takes new options while the line stays open: new and changed devices join, removed ones leave. On kUnsupported
  /// (the default) and every other error nothing was changed, and the caller recreates the network. `make` accepted the
  /// same options before.
  virtual Result<void> change(const NetworkConfig& config);
  /// The island ends: the last chance to stop what devices would continue without the island. True: the network calls
  /// `closed` once, in a later turn, but is destroyed after kClosingTime in any case. False (the default): there is
  /// nothing to send, or no line to send it on, and `closed` is never called. Later commands may be refused.
  virtual bool close(std::function<void()> closed);
  /// All devices, if the options list them; nullopt (the default) if only the line knows them.
  virtual std::optional<std::vector<ListedDevice>> listed() const;
  /// What the options name and this host lacks at the moment, for `check`; nothing by default. Opens no line.
  virtual std::vector<Missing> missing() const;
  /// The properties of the network itself that users may set: none by default, always the same.
  virtual std::vector<Control> controls() const;
  /// Sets the property `name` to what a user wrote. Called in a turn of its own. The user gets the error as the reason.
  /// The default knows no property: kNotFound.
  virtual Result<void> control(std::string_view name, std::string_view text);
};

/// One type of network. Set the fields by name.
struct NetworkType {
  std::string_view name;           ///< `log`
  std::string_view summary;        ///< one line for users
  std::string_view sample_config;  ///< the plug-in's sample.yaml: a map of one network id
  /// Reads the options, reports each error by config.options.error(), and constructs the network; opens nothing.
  /// kInvalid if it reported an error. Use make_network().
  Result<std::unique_ptr<Network>> (*make)(const NetworkConfig& config, NetworkHost& host);
  /// Longest pause between attempts to open the line: 1 s for local and unicast peers, 30 s where attempts disturb
  /// others.
  Duration longest_pause = std::chrono::seconds(1);
  /// The options name every device: the proxy then does not show devices that it remembers and the options do not name.
  bool lists_devices = false;
  /// The network finds its devices by itself and hears from some of them only later: a Join that was not heard may be
  /// of a new device, and `discovery` applies to it. False: such a device comes from the options, and is always
  /// admitted.
  bool discovers = false;
  /// The options that name files which are read with the options: a reload compares their contents too. What it names
  /// lives as long as the program.
  std::span<const std::string_view> file_options{};
  /// Roaming domain of types whose addresses are unique in the world (docs/roaming.md); a key part, empty = none. The
  /// option `roaming` overrides it.
  std::string_view roaming{};
  /// The devices send no sign of life: without the option `silence` they never become unreachable by silence.
  bool quiet = false;
  /// A quiet device can be asked whether it is there: the proxy sends a Probe for each remembered device at start, and
  /// for devices that were silent for half the silence period, and for three quarters of it.
  bool probes = false;
  /// The names that devices announce are unique in the network: `devices:` may name a device by them.
  bool unique_names = false;
  /// Commands may be answered only after this time, at most 30 s: the proxy waits for the Acknowledge at least so long.
  /// 0 = within the confirmation wait of the island.
  Duration answer_time{0};
};

/// The error of a network whose options are wrong: what is wrong stands in config.options.errors().
Error wrong_options(const NetworkConfig& config);

/// The options of a network as `read(config)` or `read(config, host.transports())` returns them; kInvalid if `read`
/// reported an error to config.options.
template <auto read>
auto read_options(const NetworkConfig& config, NetworkHost& host) {
  const auto read_them = [&] {
    if constexpr (std::is_invocable_v<decltype(read), const NetworkConfig&>)
      return read(config);
    else
      return read(config, host.transports());
  };
  using Options = decltype(read_them());
  const std::size_t errors = config.options.errors().lines().size();
  Options options = read_them();
  if (config.options.errors().lines().size() > errors) return Result<Options>(fail(wrong_options(config)));
  return Result<Options>(std::move(options));
}

/// NetworkType::make for a class with a constructor (config, options, host), which is called only with options in which
/// `read` found no error.
template <class Type, auto read>
Result<std::unique_ptr<Network>> make_network(const NetworkConfig& config, NetworkHost& host) {
  auto options = read_options<read>(config, host);
  if (!options) return fail(std::move(options.error()));
  return std::make_unique<Type>(config, std::move(*options), host);
}

}  // namespace rubicon::network
