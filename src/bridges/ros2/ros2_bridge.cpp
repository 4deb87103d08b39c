#include "bridges/ros2/ros2_bridge.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "bridges/house.h"
#include "bridges/ros2/diagnostics.h"
#include "bridges/ros2/imports.h"
#include "bridges/ros2/names.h"
#include "bridges/ros2/node.h"
#include "bridges/ros2/topics.h"
#include "model/findings.h"
#include "tuples/dds/dds_threads.h"

namespace rubicon::bridges::ros2 {

namespace {

constexpr Duration kFirstPause = std::chrono::milliseconds(500), kMaxPause = std::chrono::seconds(10);
constexpr Duration kLookAtInterfaces = std::chrono::seconds(2);

std::string environment(const char* name) {
  const char* text = std::getenv(name);
  return text != nullptr ? text : "";
}

class Ros2Bridge final : public Bridge {
 public:
  Ros2Bridge(Options options, const BridgeHost& host)
      : host_(host),
        options_(std::move(options)),
        log_({host.log, "bridge " + host.name}, host.scheduler),
        cyclone_log_(
            host.scheduler, [&loop = host.scheduler](std::function<void()> call) { loop.post(std::move(call)); },
            host.log),
        house_(host_, options_, house_calls()),
        topics_(host_, options_, house_),
        diagnostics_(host_, options_, house_),
        imports_(host_, options_, topics_) {}
  ~Ros2Bridge() override { detach("the bridge ended"); }

  void start() override {
    imports_.start();
    house_.start();
    open();
  }
  BridgeStatus status() const override;

 private:
  House::Callbacks house_calls();
  std::string node_name() const {
    return host_.island ? fmt::format("rubicon_{}", number(*host_.island)) : "rubicon_" + token(host_.name);
  }
  void open();
  void look_after();
  void detach(const std::string& reason);
  void complain(BridgeStatus& status) const;
  /// Others that publish our topics.
  std::size_t doubles() const;

  BridgeHost host_;
  Options options_;
  base::LimitedLog log_;
  tuples::dds::CycloneLog cyclone_log_;
  House house_;
  Topics topics_;
  Diagnostics diagnostics_;
  Imports imports_;
  std::unique_ptr<Node> node_;
  std::string reason_ = "it was not opened yet";
  Duration pause_ = kFirstPause;
  std::uint64_t opened_ = 0;
  Timer retry_;
};

House::Callbacks Ros2Bridge::house_calls() {
  return {.point =
              [this](PointEntry& point) {
                if (!point.fresh) diagnostics_.changed(*point.device);
                topics_.changed(point);
              },
          .status = [](PointEntry&) {},
          .device =
              [this](DeviceEntry& device) {
                diagnostics_.changed(device);
                topics_.described(device);
              },
          .network = [this](NetworkEntry&) { diagnostics_.networks_changed(); },
          .island = [this](IslandEntry& island) { diagnostics_.island_changed(island); },
          .point_gone = [this](PointEntry& point) { topics_.gone(point); },
          .device_gone =
              [this](DeviceEntry& device) {
                diagnostics_.gone(device);
                topics_.gone(device);
              },
          .renamed = [](DeviceEntry&) {},
          .network_gone = [](OwnerId, const std::string&) {},
          .island_gone = [](IslandEntry&) {},
          .is_ours = [this](std::string_view domain) { return domain == fmt::to_string(options_.reach.domain); }};
}

void Ros2Bridge::open() {
  auto node = Node::open(host_, options_, node_name(),
                         {[this](dds_entity_t endpoint) {
                            topics_.news(endpoint);
                            diagnostics_.news(endpoint);
                            imports_.news(endpoint);
                          },
                          [this] { imports_.changed(); }});
  if (!node) {
    if (std::exchange(reason_, node.error().text) != node.error().text)
      log_.warning("domain", reason_ + "; it is tried again");
    retry_ = host_.scheduler.after(pause_, [this] { open(); });
    pause_ = std::min(2 * pause_, kMaxPause);
    return;
  }
  node_ = std::move(*node);
  ++opened_;
  reason_.clear();
  pause_ = kFirstPause;
  topics_.attach(node_.get());
  diagnostics_.attach(node_.get());
  imports_.attach(node_.get(), {});
  look_after();
}

/// Cyclone DDS stays with the addresses that it began with.
void Ros2Bridge::look_after() {
  retry_ = host_.scheduler.after(kLookAtInterfaces, [this] {
    if (!node_->is_displaced()) return look_after();
    detach("an interface has another address, or is gone");
    log_.warning("domain", reason_ + "; it is opened again");
    open();
  });
}

void Ros2Bridge::detach(const std::string& reason) {
  retry_.cancel();
  reason_ = reason;
  topics_.attach(nullptr);
  diagnostics_.attach(nullptr);
  imports_.attach(nullptr, reason);
  node_.reset();
}

std::size_t Ros2Bridge::doubles() const {
  const auto& all = node_->graph().publications();
  return static_cast<std::size_t>(
      std::count_if(all.begin(), all.end(), [this](const auto& one) { return topics_.has(one.second.topic); }));
}

void Ros2Bridge::complain(BridgeStatus& status) const {
  const auto& graph = node_->graph();
  if (doubles() > 0)
    status.add({},
               "others publish topics with our names: two bridges with one namespace, or a robot with the name of "
               "a building?");
  if (graph.sees_hashes() && graph.sees_none())
    status.add(model::findings::kRosGidsMixed,
               fmt::format("nodes of both sizes of Gid are in the domain (up to Humble, and from Iron on){}",
                           options_.distribution == Distribution::kAuto ? ": our node has no name" : ""));
  topics_.complain(status);
  imports_.complain(status);
  if (graph.robots() == 0 && graph.publications().empty())
    status.add(model::findings::kRosDomainEmpty, "no other node is in this domain");
}

BridgeStatus Ros2Bridge::status() const {
  BridgeStatus status;
  status.state = node_ ? "up" : "connecting";
  status.reason = reason_;
  if (node_) complain(status);
  status.peer = fmt::format("ROS domain {}", options_.reach.domain);
  status.counters["opened"] = opened_;
  status.counters["robots"] = node_ ? node_->graph().robots() : 0;
  status.counters["devices"] = house_.devices();
  status.counters["points"] = house_.points();
  topics_.count(status.counters);
  imports_.count(status.counters);
  return status;
}

}  // namespace

std::unique_ptr<Bridge> make(ConfigReader& options, const std::string&, const BridgeHost* host) {
  const auto before = options.errors().lines().size();
  options.node("type");
  auto read = read_options(options, environment);
  options.finish();
  if (host == nullptr || options.errors().lines().size() != before) return nullptr;
  return std::make_unique<Ros2Bridge>(std::move(read), *host);
}

}  // namespace rubicon::bridges::ros2
