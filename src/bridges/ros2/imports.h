#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "base/log.h"
#include "base/scheduler.h"
#include "bridges/bridge.h"
#include "bridges/ros2/messages.h"
#include "bridges/ros2/node.h"
#include "bridges/ros2/ros2_bridge.h"
#include "bridges/ros2/topics.h"
#include "model/point_keys.h"

namespace rubicon::bridges::ros2 {

/// Topics of robots as sensors of devices, which are tuples of the bridge's own component:
/// `<prefix>.ros2-<bridge>.<device>.sensor.<type>-<instance>`.
class Imports {
 public:
  static constexpr std::size_t kMaxTopics = 256;  ///< that `import: auto` takes
  static constexpr std::size_t kMaxSensors = 2000;
  /// A topic of `import: auto` is forgotten this long after its last publisher left: robots that come and go under new
  /// names would use up the bounds.
  static constexpr Duration kRemembered = std::chrono::hours(24);

  /// `topics`: ours, which are not taken for those of a robot.
  Imports(const BridgeHost& host, const Options& options, const Topics& topics);

  /// The state of the line as devices of an island have it.
  void start();
  /// nullptr: there is none any more, for this reason.
  void attach(Node* node, const std::string& reason);
  /// Publications of others, or topics of ours.
  void changed() { look_.request(); }
  void news(dds_entity_t endpoint);

  void complain(BridgeStatus& status) const;
  void count(std::map<std::string, std::uint64_t>& counters) const;

 private:
  struct Sensor {
    model::PointKey key;
    const model::Type* type = nullptr;
    std::string unit;  ///< of what the message says
    model::Quality quality = model::Quality::kUnknown;
    std::string reason{}, value{};
    dds_instance_handle_t from = 0;  ///< the publisher of its newest message; 0: none, or it is gone
    WallTime since{}, heard{}, changed{};
    tuples::TupleRef value_tuple{}, status_tuple{};
  };
  struct Robot {
    std::set<std::string> sensors;  ///< ids
    std::size_t open = 0;           ///< topics that have a publisher
    WallTime since{};
    bool shown_open = false;
  };
  struct Import {
    std::string topic;
    Form form{};
    const ImportRule* rule = nullptr;  ///< nullptr: by `auto`
    std::string device;
    Endpoint reader{};
    bool reliable = false, kept = false;                       ///< QoS of the reader
    std::uint64_t seen = 0;                                    ///< the look that saw a publication
    std::optional<SteadyTime> left{};                          ///< when a look saw none any more
    std::map<std::string, std::unique_ptr<Sensor>> sensors{};  ///< by the name of the part
  };

  /// Publications of one topic.
  using Offers = std::span<const Publication* const>;

  bool imports_nothing() const { return options_.imports.empty() && !options_.imports_all; }
  void look();
  void consider(Offers offers);
  void open(const Publication& offer, Form form, const ImportRule* rule);
  void close(Import& import, const std::string& reason);
  void leave(Import& import);
  void forget_left();
  void forget(const Import& import);
  void erase_tuples(const model::PointKey& sensor);
  void follow_publishers(Import& import);
  void take(Import& import);
  bool wants(const Import& import, const Part& part) const;
  std::string id_of(const Import& import, const Part& part) const;
  Sensor* sensor_of(Import& import, const Part& part);
  void heard(Sensor& sensor, const Part& part, WallTime stamp);
  void offline(Sensor& sensor, const std::string& reason);
  void state(Sensor& sensor, model::Quality quality, const std::string& reason);
  void show_robot(const std::string& device);
  void describe_robot(const std::string& device);
  void show_line(const std::string& line, const std::string& reason);
  const model::Type* type_of_part(const Import& import, const Part& part) const;

  const BridgeHost& host_;
  const Options& options_;
  const Topics& topics_;
  Node* node_ = nullptr;
  base::LimitedLog log_;
  model::TypeCatalogue types_;
  model::NetworkKey network_;
  std::map<std::string, Import> imports_;  ///< by topic; remain for kRemembered when their publishers are gone
  std::map<dds_entity_t, Import*> by_endpoint_;
  std::map<std::string, Robot> robots_;
  std::map<std::string, std::string> faults_;  ///< why topics are not imported, by topic
  std::size_t left_out_ = 0, sensors_ = 0;
  std::uint64_t messages_ = 0, bad_ = 0, looks_ = 0;
  base::PacedCall look_;
  base::Deadline forgets_;
};

}  // namespace rubicon::bridges::ros2
