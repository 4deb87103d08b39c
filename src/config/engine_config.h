#pragma once

#include <string>
#include <vector>

#include "base/config_reader.h"
#include "config/mqtt_space_config.h"
#include "tuples/carry/carry_rules.h"
#include "tuples/dds/dds_options.h"
#include "tuples/peis/peis_options.h"

namespace rubicon::config {

/// `tuples.trust`: whether peers have to prove who they are, and where the certificates lie.
struct TrustSetup {
  enum class Choice : std::uint8_t { kDefault, kNo, kYes };
  Choice choice = Choice::kDefault;  ///< kDefault: yes if the host has a folder
  std::string folder;                ///< of kYes, as configured; empty = that of the host

  friend bool operator==(const TrustSetup&, const TrustSetup&) = default;
};

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
  TrustSetup trust;
  std::string trust_folder;             ///< that counts, as whoever runs the island found it; empty = without trust
  tuples::carry::CarryRules carry;      ///< between engines, by their names
  std::vector<std::string> carry_path;  ///< of its key: `tuples.carry`, or `tuples.peis.carry`
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
