#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/config_reader.h"
#include "base/log.h"
#include "base/scheduler.h"
#include "rubicon/tuple_space.hpp"
#include "transport/transports.h"
#include "tuples/judge.h"

/// Bridges show the tuple space to programs that speak another protocol, and take their commands: ordinary components,
/// which have no other way to an island than its tuples (docs/mqtt.md).
namespace rubicon::bridges {

/// What a bridge says of itself: the tuple `<prefix>.bridge.<name>.status`.
struct BridgeStatus {
  std::string state;   ///< connecting, up, or refused (the other side is there and does not accept us)
  std::string reason;  ///< of a state that is not up; of `up` what does not work though; empty = nothing
  std::string peer;    ///< what it is connected to: `127.0.0.1:1883`
  std::map<std::string, std::uint64_t> counters{};
  std::vector<std::pair<std::string, std::string>> findings{};  ///< what add() got

  /// One more reason; `finding`: its word (model/findings.h), empty = it has none.
  void add(std::string_view finding, const std::string& text);

  friend bool operator==(const BridgeStatus&, const BridgeStatus&) = default;
};

/// What a bridge is made of. All references must outlive it.
struct BridgeHost {
  std::string name;  ///< `ha`: of the bridge in its configuration
  Scheduler& scheduler;
  TupleSpace& space;  ///< of its own component
  transport::Transports& transports;
  LogSink& log;
  std::optional<OwnerId> island{};  ///< whose configuration names it; nullopt = it runs alone
  std::string prefix = "proxy";     ///< of the keys of that island
  /// Judges and records what the bridge asks for as the member `bridge:<name>`; nullptr: it runs alone, and islands
  /// judge its component.
  tuples::Judge* judge = nullptr;
};

/// A running bridge; destroyed = ended. It keeps trying if the other side cannot be reached.
class Bridge {
 public:
  virtual ~Bridge() = default;
  virtual void start() = 0;
  virtual BridgeStatus status() const = 0;
};

/// One kind of bridges.
struct BridgeType {
  std::string_view name;     ///< `mqtt`: the word behind `type:`
  std::string_view summary;  ///< for people
  /// Reads the options (relative paths start at `directory`), errors into the reader; without a host it only checks
  /// them and returns nullptr, as it does where there are errors.
  std::unique_ptr<Bridge> (*make)(ConfigReader& options, const std::string& directory, const BridgeHost* host);
};

std::span<const BridgeType> bridge_types();
/// nullptr for every other word.
const BridgeType* find_bridge_type(std::string_view name);
/// Their names with commas, for messages.
std::string bridge_type_names();

/// JSON of a status, for the tuple.
std::string to_json(const BridgeStatus& status, WallTime since);

}  // namespace rubicon::bridges
