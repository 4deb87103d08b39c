#pragma once

#include <dds/dds.h>

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>

#include "base/scheduler.h"
#include "bridges/bridge.h"
#include "bridges/ros2/graph.h"
#include "bridges/ros2/messages.h"
#include "bridges/ros2/ros2_bridge.h"
#include "tuples/dds/entity.h"

namespace rubicon::bridges::ros2 {

using tuples::dds::Entity;

/// Brings what Cyclone's threads tell into the loop: collects the entities that have news, and posts one call.
class News {
 public:
  /// `call` runs in the loop, once for each entity with news.
  News(Scheduler& scheduler, std::function<void(dds_entity_t)> call);
  /// The entities that were made with the listener must be deleted before.
  ~News();
  News(const News&) = delete;
  News& operator=(const News&) = delete;
  const dds_listener_t* listener() const { return listener_.get(); }

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;
  tuples::dds::DdsListener listener_;
};

/// How samples of a topic are kept: rmw's profiles (rmw/qos_profiles.h).
enum class Keep : std::uint8_t {
  kReadings,  ///< reliable, volatile, keep-last 10
  kState,     ///< reliable, transient-local, keep-last 1
};

/// A reader or a writer of one topic. Movable; destroyed = gone.
struct Endpoint {
  Entity topic, end;
  explicit operator bool() const { return static_cast<bool>(end); }
  dds_entity_t get() const { return end.get(); }
  /// A topic goes after what uses it.
  void reset() {
    end.reset();
    topic.reset();
  }
};

/// Our participant of ROS 2: a domain of its own inside this process, which others see as Reach::domain, one
/// participant with a ROS node, and who else is there.
class Node {
 public:
  struct Callbacks {
    std::function<void(dds_entity_t)> news;   ///< an endpoint has a sample, or another match
    std::function<void()> endpoints_changed;  ///< publications of others, or endpoints of ours
  };
  /// kIo, with what Cyclone DDS says.
  static Result<std::unique_ptr<Node>> open(const BridgeHost& host, const Options& options, std::string name,
                                            Callbacks calls);
  ~Node();
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

  /// The names are ROS names. kIo.
  Result<Endpoint> writer(const std::string& name, Form form, Keep keep);
  Result<Endpoint> reader(const std::string& name, Form form, Keep keep);
  /// With what the publisher offers; keeps the newest sample only.
  Result<Endpoint> reader_for(const Publication& publication, Form form);

  const Graph& graph() const { return graph_; }
  /// Whether the interfaces have other addresses than at the start, or are gone: it must be opened again.
  bool is_displaced() const;

 private:
  Node(const BridgeHost& host, const Options& options, std::string name, Callbacks calls);
  Result<void> enter();
  Result<void> look();
  void news_of(dds_entity_t entity);
  Result<Endpoint> make(const std::string& topic, const dds_topic_descriptor_t& descriptor, const dds_qos_t* qos,
                        bool is_writer);
  void say_who_we_are();

  const Options& options_;
  std::string name_;
  Callbacks callbacks_;
  News news_;
  Entity domain_, participant_;
  Entity publisher_, subscriber_;  ///< an entity of Cyclone DDS has at most 16,382 others below it (dds_handles.c)
  std::string addresses_;
  Graph graph_;
  Entity participants_, publications_, subscriptions_;
  Gids gids_ = Gids::kNone;
  std::uint64_t told_ = 0;  ///< Graph::our_changes() that `ros_discovery_info` has
  Endpoint info_;
  base::PacedCall tell_;
};

/// The number of readers of others that a writer has.
std::size_t matched_readers(dds_entity_t writer);

}  // namespace rubicon::bridges::ros2
