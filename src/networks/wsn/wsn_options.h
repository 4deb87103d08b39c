#pragma once

#include <optional>
#include <string>

#include "motes/mote_codec.h"
#include "network/network.h"
#include "networks/wsn/share/forwarder.h"
#include "networks/wsn/sink/source.h"

namespace rubicon::networks::wsn {

/// What a `type: wsn` network is told in the configuration.
struct WsnOptions {
  sink::Source source;
  motes::CodecOptions codec;  ///< its island is ours
  bool read_updates = false;  ///< `sampling: read-updates`
  /// The sink is told the island's id again each so often; nullopt = when the line is opened only.
  std::optional<Duration> island_check = std::chrono::seconds(30);
  /// Who application messages of motes go to that are for this island; kNoOwner = those who listen here.
  OwnerId messages_to = model::kNoOwner;
  bool messages_as_json = false;                 ///< those of the learning and synaptic layers
  std::optional<share::ForwarderOptions> share;  ///< nullopt = the sink is not shared
};

/// Reads the options; what is wrong stands in the reader's errors.
WsnOptions read_wsn_options(const network::NetworkConfig& config);

}  // namespace rubicon::networks::wsn
