#pragma once

#include <string>

#include "base/config_reader.h"
#include "tuples/carry/carry_rules.h"
#include "tuples/dds/dds_options.h"
#include "tuples/peis/peis_options.h"

namespace rubicon::config {

/// `tuples:`: how the components reach each other.
struct EngineSetup {
  bool dds = true;
  bool peis = false;  ///< neither: within this process only
  tuples::dds::DdsOptions options;
  tuples::peis::PeisOptions peis_options;
  tuples::carry::CarryRules carry;  ///< from one engine to the other
  std::string
      place;  ///< `home.yaml:2:9: tuples: `, for errors that only the start finds; empty = the file has no such section
};

/// Everything wrong is in the reader's errors. Whether the interfaces are there is for the start to find out: a
/// configuration may be checked elsewhere.
EngineSetup read_engine(ConfigReader& root);

}  // namespace rubicon::config
