#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/config_reader.h"
#include "base/text.h"
#include "transport/mqtt_options.h"
#include "tuples/carry/carry_rules.h"
#include "tuples/dds/dds_options.h"
#include "tuples/mqtt/mqtt_ecology.h"
#include "tuples/peis/peis_ecology.h"

namespace rubicon::config {

/// `tuples.mqtt`: the broker at which components of all sites meet (docs/sites.md).
struct MqttSpaceSetup {
  transport::MqttBrokerOptions broker;
  std::vector<base::HostPort> spare;  ///< used while those before are away, with the user and TLS of the first
  std::string space = "default";
  Duration lease = std::chrono::seconds(20);
  bool trust_broker = false;
  bool watch_all = false;

  /// With the password, as it is when the program starts; the errors of MqttBrokerOptions::with_password().
  Result<tuples::mqtt::SpaceOptions> options(transport::Transports& transports) const;
  /// The folder of the realm whose authority the broker is checked by (docs/sites.md); empty = it is in none.
  std::string realm_folder() const;
};

/// Reads the map; relative paths start at `directory`. Everything wrong is in the reader's errors.
MqttSpaceSetup read_mqtt_space(ConfigReader& tuples, const std::string& directory);

/// `tuples.trust`. Earlier releases had certificates for DDS: `yes`, or a folder. kNo: the author of the file knows
/// that DDS proves no identity.
enum class OldTrust : std::uint8_t { kUnsaid, kNo, kYes };

/// `tuples:`: how the components reach each other.
struct EngineSetup {
  bool host = true;           ///< with all programs of this host
  bool dds = false;           ///< by DDS
  bool mqtt = false;          ///< at a broker
  bool peis = false;          ///< with PEIS kernels; no engine: within this process only
  std::string folder, space;  ///< of engine host; empty = the defaults of tuples/host/folder.h
  tuples::dds::DdsOptions options;
  MqttSpaceSetup mqtt_space;
  tuples::peis::PeisOptions peis_options;
  OldTrust old_trust = OldTrust::kUnsaid;
  /// The sign that the island had certificates for DDS in an earlier release; whoever starts the island fills it in.
  /// Not empty: `dds` is off until the file says `trust: no`.
  std::string held_back;
  std::optional<ConfigPlace> trust_lan;  ///< where the file has that key
  tuples::carry::CarryRules carry;       ///< between engines, by their names
  std::vector<std::string> carry_path;   ///< of its key: `tuples.carry`, or `tuples.peis.carry`
  std::string
      place;  ///< `home.yaml:2:9: tuples: `, for errors that only the start finds; empty = the file has no such section
  bool closed = false;  ///< other users of the host are restricted; the program that runs the island finds that out
  std::vector<std::string> warnings;  ///< keys that mean something else than in earlier releases; each with its place

  bool alone() const { return !host && !dds && !mqtt && !peis; }
};

/// Everything wrong is in the reader's errors; relative paths start at `directory`. Whether the interfaces are there is
/// for the start to find out: a configuration may be checked elsewhere.
EngineSetup read_engine(ConfigReader& root, const std::string& directory);

/// Reads `carry` of `tuples`: what the island `own` (0 = not known) carries between its engines, which were read
/// before.
void read_carry(ConfigReader& tuples, std::uint32_t own, EngineSetup& engine);
/// The same of `tuples.peis`, as earlier releases have it: between dds and peis.
void read_carry_of_peis(ConfigReader& peis, std::uint32_t own, EngineSetup& engine);

/// `4711 and kitchen.** from dds to mqtt`, one text for each rule.
std::vector<std::string> carried(const tuples::carry::CarryRules& rules);

}  // namespace rubicon::config
