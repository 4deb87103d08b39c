#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <tuple>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "base/log.h"
#include "base/scheduler.h"
#include "bridges/bridge.h"
#include "bridges/command_desk.h"
#include "bridges/house.h"
#include "bridges/ros2/messages.h"
#include "bridges/ros2/node.h"
#include "bridges/ros2/ros2_bridge.h"

namespace rubicon::bridges::ros2 {

/// The points of the building as topics: a writer each, sampled while it has a reader of ROS, and with `commands` a
/// reader of `.../set` and a writer of `.../outcome`.
class Topics {
 public:
  /// Topics without `patterns`, and with them: each costs discovery in the whole domain.
  static constexpr std::size_t kMaxUsual = 500, kMaxTopics = 10'000;
  /// Commands of one topic begin at most once in this time; of more the newest is taken.
  static constexpr Duration kCommandPause = std::chrono::milliseconds(20);

  Topics(const BridgeHost& host, const Options& options, House& house);

  /// nullptr: there is none any more; what it made must go before it.
  void attach(Node* node);
  /// A device was described, or has other points: makes topics of them once it is complete.
  void described(DeviceEntry& device);
  void changed(PointEntry& point);
  void gone(PointEntry& point);
  void gone(DeviceEntry& device);
  /// Of an endpoint of ours; others are ignored.
  void news(dds_entity_t endpoint);

  /// Whether a topic of ours has this name.
  bool has(const std::string& name) const { return by_name_.contains(name); }
  /// What does not work, for the status.
  void complain(BridgeStatus& status) const;
  void count(std::map<std::string, std::uint64_t>& counters) const;

 private:
  struct Topic {
    PointEntry* point = nullptr;
    PointEntry* longitude = nullptr;  ///< of a position
    Form form{};
    bool state = false;
    std::string wanted;  ///< that its key gives
    std::string name;    ///< another one if several want that; empty if somebody has that one, too: not shown
    Endpoint values{}, sets{}, outcomes{};
    std::size_t readers = 0;
    Handle demand{}, longitude_demand{};
    bool shown = false;     ///< a late reader gets its value
    bool missed = false;    ///< the newest value was not published
    bool marked = false;    ///< waits in marked_
    std::string waiting{};  ///< the newest command of the pause
    bool has_waiting = false;
    Timer pause{};
  };
  /// A reading that waits for the end of the turn, when its quality is known.
  struct Sample {
    Topic* topic;
    std::string value;
    WallTime time;
  };

  struct ByName {
    bool operator()(const DeviceEntry* left, const DeviceEntry* right) const {
      return std::tie(left->island, left->key) < std::tie(right->island, right->key);
    }
  };
  void work();
  bool make_topics(DeviceEntry& device);
  void forget_other_form(PointEntry& point);
  void make_topic(PointEntry& point, PointEntry* longitude);
  void name(Topic& topic);
  void open(Topic& topic);
  void close(Topic& topic);
  void mark(Topic& topic);
  void publish(Topic& topic, std::string_view value, WallTime time);
  void publish_newest(Topic& topic);
  void follow_readers(Topic& topic);
  Handle want(const PointEntry& point) const;
  bool may_command(const PointEntry& point) const;
  void take_commands(Topic& topic);
  void command(Topic& topic, std::string text);
  void go_on(Topic& topic);
  void answer(Topic& topic, const client::Outcome& outcome);
  std::string space_of(const PointEntry& point) const;

  const BridgeHost& host_;
  const Options& options_;
  House& house_;
  Node* node_ = nullptr;
  base::LimitedLog log_;
  CommandDesk desk_;
  std::map<std::string, std::set<Topic*>> wanted_;          ///< by the name that they want
  std::unordered_map<const PointEntry*, Topic*> by_point_;  ///< a position under both of its points
  std::unordered_map<const Topic*, std::unique_ptr<Topic>> topics_;
  std::unordered_map<dds_entity_t, Topic*> by_endpoint_;
  std::unordered_map<std::string, Topic*> by_name_;
  std::set<DeviceEntry*, ByName> devices_;  ///< wait to be complete
  std::unordered_set<Topic*> unopened_;
  std::vector<Sample> samples_;
  std::vector<Topic*> marked_;
  std::uint64_t published_ = 0, dropped_ = 0, unfit_ = 0, commands_ = 0, refused_ = 0, superseded_ = 0;
  std::unordered_set<const PointEntry*> left_out_;
  std::string failure_;  ///< of an endpoint
  base::OncePerTurn soon_;
  Timer later_;
  base::Lifetime lifetime_;
};

}  // namespace rubicon::bridges::ros2
