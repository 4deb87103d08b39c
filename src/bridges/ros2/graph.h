#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "bridges/ros2/ros2_bridge.h"
#include "tuples/dds/entity.h"

namespace rubicon::bridges::ros2 {

using Guid = tuples::dds::Participant;  ///< 16 bytes, of a participant or of an endpoint

/// Length of a Gid in `ros_discovery_info` (rmw_dds_common, Gid.msg): 24 octets up to Humble, 16 from Iron on.
enum class Gids : std::uint8_t { kNone, k24, k16 };
/// `sees_hashes`, `sees_none`: ROS participants whose endpoints have a `typehash` (from Iron on), or have none.
Gids gids_for(Distribution distribution, bool sees_hashes, bool sees_none);

/// The value of a key in user data of ROS, `enclave=/;typehash=...;`; nullopt where it has none.
std::optional<std::string_view> user_datum(std::string_view user_data, std::string_view key);

/// A publisher of another participant.
struct Publication {
  std::string topic;  ///< ROS name
  std::string type;   ///< `std_msgs/msg/Float64`
  bool reliable = false, kept = false;
  bool is_of_bridge = false;  ///< a building's, not a robot's
};

/// Who is in the domain, from the built-in topics of DDS.
class Graph {
 public:
  /// Of publications and participants each; more are not looked at.
  static constexpr std::size_t kMaxSeen = 20'000;

  /// `us`: our own participant. `changed`: publications of others or endpoints of ours came or went.
  Graph(const Guid& us, std::function<void()> changed) : us_(us), changed_(std::move(changed)) {}

  void take_participants(dds_entity_t reader);
  void take_publications(dds_entity_t reader);
  void take_subscriptions(dds_entity_t reader);

  const std::map<Guid, Publication>& publications() const { return publications_; }
  const std::set<Guid>& our_readers() const { return our_readers_; }
  const std::set<Guid>& our_writers() const { return our_writers_; }
  /// Counts changes of the two.
  std::uint64_t our_changes() const { return our_changes_; }
  /// ROS participants but other bridges.
  std::size_t robots() const;
  bool sees_hashes() const;
  bool sees_none() const;

 private:
  struct Known {
    bool is_ros = false, is_bridge = false;
    bool has_hash = false, has_none = false;  ///< of its endpoints
  };
  void take_endpoints(dds_entity_t reader, bool are_writers);
  void see(const dds_builtintopic_endpoint_t& endpoint, bool is_writer);

  Guid us_;
  std::function<void()> changed_;
  std::map<Guid, Known> participants_;
  std::map<Guid, Publication> publications_;
  std::set<Guid> our_readers_, our_writers_;
  std::uint64_t our_changes_ = 0;
};

/// What `ros_discovery_info` says of us: writes it in the form of the Gids. Not for kNone.
void write_discovery_info(dds_entity_t writer, Gids gids, const Guid& us, const std::string& node, const Graph& graph);
const dds_topic_descriptor_t& discovery_info_descriptor(Gids gids);

}  // namespace rubicon::bridges::ros2
