#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/config_reader.h"
#include "base/log.h"
#include "base/scheduler.h"
#include "model/message.h"
#include "model/type_catalogue.h"
#include "rubicon/result.hpp"
#include "transport/transports.h"

namespace rubicon::network {

/// A tuple that is followed; destroyed = not any more.
using TupleWatch = std::shared_ptr<void>;

/// What a plug-in knows of the world. Owned by the supervisor, outlives the network.
class NetworkHost {
 public:
  virtual ~NetworkHost() = default;

  /// Upwards: Join, KeepAlive, Leave, Updates, Acknowledge, State, Opaque. Fill source.device and body (and the
  /// destination if it is not this island); the host fills in the rest. Only queues; may be called from anywhere but
  /// make().
  virtual void deliver(Message message) = 0;
  /// The line is lost: open() will be called again after a pause. What waits for the line may stay in the network.
  virtual void failed(Error why) = 0;

  /// Values of a tuple, for networks that show them to their devices: the key of one of this island's, or `ID:key` of
  /// another's. `call` is told what there is, in a later turn, and each change (empty: it is gone), until the result is
  /// destroyed; nobody is asked at make() time. kInvalid for what is no tuple. By default there are none: kUnsupported.
  virtual Result<TupleWatch> follow(std::string_view tuple, std::function<void(std::string_view value)> call);

  virtual Scheduler& scheduler() = 0;
  virtual transport::Transports& transports() = 0;
  virtual const Log& log() const = 0;

  /// deliver() in short: `body` from `device` to this island's gateway.
  void deliver(std::string device, model::Body body);
};

/// What `make` gets. `options` is the network's map without the keys common to all networks (type, silence, devices,
/// ...): read every key, then the caller reports the unknown ones.
struct NetworkConfig {
  std::string id;  ///< `wsn-1`
  IslandId island{};
  ConfigReader& options;
  const TypeCatalogue& types;
  std::string directory;  ///< of the configuration file: relative paths start here; empty = the working directory
  /// Reads further YAML of the site's (`file` for the places in errors); nullptr where there is none.
  Result<ConfigNode> (*read_yaml)(std::string_view text, std::string_view file) = nullptr;
  std::size_t most_devices = 20000;  ///< `limits.devices` of the island
};

/// A device that the options name, with all its points.
struct ListedDevice {
  std::string address;
  std::vector<model::Capability> capabilities;
};

/// What an option names and this host does not have: a file, an interface.
struct Missing {
  std::string option;
  std::string text;
};

/// The time all networks of an island together have for their last words to their devices when it ends.
inline constexpr Duration kClosingTime = std::chrono::seconds(2);

/// A network of devices behind one line. Destroyed = stopped, at once and without a word to the host.
class Network {
 public:
  virtual ~Network() = default;
  /// Makes the line, again after failed(). Never blocks: success may be announced later by State{kUp}; a Result with an
  /// error counts as failed().
  virtual Result<void> open() = 0;
  /// Downwards: Actuate, Sample, SetProperty, Opaque, Probe; the destination is a device of this network. An error
  /// answers the request (kUnsupported is a valid answer, silence is not); else an Acknowledge with the request's
  /// number follows.
  virtual Result<void> send(const Message& message) = 0;
  /// Takes new options without losing the line: joins what is new or changed, lets leave what is gone. kUnsupported
  /// (the default) and every other error mean that nothing was changed; the caller then makes the network anew. The
  /// options were accepted by `make` before.
  virtual Result<void> change(const NetworkConfig& config);
  /// The island ends: the last chance to tell devices what they should not go on with. True: `closed` is called once,
  /// in a later turn; who takes longer than kClosingTime is destroyed without it. False (the default): there is
  /// nothing to say, or no line to say it on, and `closed` is never called. Commands that come after it may be refused.
  virtual bool close(std::function<void()> closed);
  /// The devices that there are, if the options list all of them; nullopt (the default): only the line knows.
  virtual std::optional<std::vector<ListedDevice>> listed() const;
  /// What the options name and this host lacks at the moment, for `check`; nothing by default. Opens no line.
  virtual std::vector<Missing> missing() const;
};

/// One type of network. `make` checks the options (reporting to options.error) and must not open anything.
struct NetworkType {
  std::string_view name;           ///< `log`
  std::string_view summary;        ///< one line for people
  std::string_view sample_config;  ///< the plug-in's sample.yaml: a map of one network id
  Result<std::unique_ptr<Network>> (*make)(const NetworkConfig&, NetworkHost&);
  /// Longest pause between attempts to open: 1 s for local and unicast peers, 30 s else.
  Duration longest_pause = std::chrono::seconds(1);
  /// Its options name every device it has: what is remembered of another one is not shown at start.
  bool lists_devices = false;
  /// The option that names a file read together with the options: a reload looks whether that changed. Empty = none.
  std::string_view file_option{};
  /// Roaming domain of types whose addresses are unique in the world (docs/roaming.md); a key part, empty = none. The
  /// configuration's word goes before.
  std::string_view roaming{};
  /// Its devices give no sign of life: without the option `silence` they are never unreachable by silence.
  bool quiet = false;
  /// Its quiet devices can be asked whether they are there: the proxy sends it Probe for each remembered device at
  /// start, and for devices that were silent for half the silence period, and for three quarters of it.
  bool probes = false;
};

}  // namespace rubicon::network
