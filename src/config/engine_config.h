#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/config_reader.h"
#include "config/mqtt_space_config.h"
#include "tuples/carry/carry_rules.h"
#include "tuples/dds/dds_options.h"
#include "tuples/peis/peis_options.h"

namespace rubicon::config {

/// `tuples.trust`. Earlier releases had certificates for DDS: `yes`, or a folder. kNo: whoever wrote the file knows
/// that nobody proves who it is there.
enum class OldTrust : std::uint8_t { kUnsaid, kNo, kYes };

/// `tuples:`: how the components reach each other.
struct EngineSetup {
  bool host = true;           ///< with all programs of this host
  bool dds = false;           ///< by DDS
  bool mqtt = false;          ///< at a broker
  bool peis = false;          ///< with PEIS kernels; no engine: within this process only
  std::string folder, space;  ///< of engine host; empty = the defaults of tuples/host/places.h
  tuples::dds::DdsOptions options;
  MqttSpaceSetup mqtt_space;
  tuples::peis::PeisOptions peis_options;
  OldTrust old_trust = OldTrust::kUnsaid;
  /// What shows that the island had certificates for DDS, as whoever runs it found it. Not empty: `dds` is off until
  /// the file says `trust: no`.
  std::string held_back;
  std::optional<ConfigPlace> trust_lan;  ///< where the file has that key
  tuples::carry::CarryRules carry;       ///< between engines, by their names
  std::vector<std::string> carry_path;   ///< of its key: `tuples.carry`, or `tuples.peis.carry`
  std::string
      place;  ///< `home.yaml:2:9: tuples: `, for errors that only the start finds; empty = the file has no such section
  bool closed = false;  ///< others of the host may not do what they like, as whoever runs the island found it
  std::vector<std::string> warnings;  ///< keys that mean something else than in earlier releases; each with its place

  bool alone() const { return !host && !dds && !mqtt && !peis; }
};

/// Everything wrong is in the reader's errors; relative paths start at `directory`. Whether the interfaces are there is
/// for the start to find out: a configuration may be checked elsewhere.
EngineSetup read_engine(ConfigReader& root, const std::string& directory);

}  // namespace rubicon::config
