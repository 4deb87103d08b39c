#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "tuples/dds/channel.h"
#include "tuples/dds/writers.h"

namespace rubicon::tuples::dds {

/// Another component. Each start has an incarnation; later starts have higher ones.
struct Peer {
  static constexpr std::size_t kMaxStarts = 4;

  /// The presence of one start, and the DDS participant that wrote it.
  struct Start {
    Participant participant{};
    std::string host, summary;
    dds_instance_handle_t publication = 0;
    std::uint64_t place = 0;  ///< order of arrival
    /// Another participant that shows the same start. It takes over when this one goes, as when the component entered
    /// the domain again and the end of its former participant was not noticed here yet.
    std::shared_ptr<const Start> heir;
  };
  using Starts = std::map<std::uint64_t, Start>;
  /// The starts that are present, by incarnation: at most one per participant, kMaxStarts in all. The highest counts.
  /// There are two if the component has just restarted or two processes use its id.
  Starts alive;

  std::uint64_t incarnation = 0;  ///< reported to the listener; 0 = down
  std::uint64_t latest = 0;       ///< the highest that was reported since this program knows the component
  Participant participant{};      ///< of that incarnation
  std::string host, summary;      ///< reported to the listener

  distant::FrameAges ages;
  std::unique_ptr<Channel> channel;  ///< made when there is something to send
  std::uint64_t last_request = 0;    ///< highest number of its remote sets; repetitions are dropped
  std::uint64_t requests_of = 0;     ///< the incarnation that sent them

  bool is_up() const { return incarnation != 0; }
};

}  // namespace rubicon::tuples::dds
