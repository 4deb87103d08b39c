#pragma once

#include <optional>
#include <string>

#include "motes/mote_codec.h"
#include "network/network.h"
#include "networks/wsn/share/forwarder.h"
#include "networks/wsn/sink/sink.h"

namespace rubicon::networks::wsn {

/// The options of a `type: wsn` network (README.md).
struct WsnOptions {
  sink::Source source;
  motes::CodecOptions codec;  ///< with the id of our island, except for recordings
  bool read_updates = false;  ///< `sampling: read-updates`
  /// Interval at which the island's id is sent to the sink again; nullopt: only when the line is opened.
  std::optional<Duration> island_check = std::chrono::seconds(30);
  /// Receiver of motes' application messages to this island; kNoOwner: the listeners in this process.
  OwnerId messages_to = model::kNoOwner;
  bool messages_as_json = false;                 ///< applies to the learning and synaptic layers
  std::optional<share::ForwarderOptions> share;  ///< nullopt: the sink is not shared
};

/// Reads the options; errors go to `config.options`.
WsnOptions read_wsn_options(const network::NetworkConfig& config);

}  // namespace rubicon::networks::wsn
