#include <gmock/gmock.h>
#include <stdlib.h>

#include <filesystem>
#include <random>
#include <set>

#include "scenarios/ecology.h"

namespace rubicon::scenarios {
namespace {

constexpr int kIslands = 2, kNetworks = 2, kDevices = 10;
constexpr OwnerId kRobot{70001};     // crashes
constexpr OwnerId kOperator{70002};  // commands, and waits for every answer

/// The devices of one network and its cable: what they really measure, which are silent, whether the cable is intact.
struct World {
  struct Device {
    double temperature = 20;
    bool lamp = false;
    bool silent = false;
    model::Sample sampled;
  };
  std::map<std::string, Device> devices;
  bool cable = true;
  network::NetworkHost* host = nullptr;
};

std::map<std::pair<std::uint32_t, std::string>, World>& worlds() {
  static std::map<std::pair<std::uint32_t, std::string>, World> all;
  return all;
}

/// A network whose devices stay in their World whatever happens to the network.
class WorldNetwork final : public network::Network {
 public:
  WorldNetwork(World& world, const TypeCatalogue& types, network::NetworkHost& host)
      : world_(world), host_(host), temperature_(types.find("temperature")->id), lamp_(types.find("switch")->id) {
    world_.host = &host;
  }
  ~WorldNetwork() override { world_.host = nullptr; }
  WorldNetwork(const WorldNetwork&) = delete;
  WorldNetwork& operator=(const WorldNetwork&) = delete;

  Result<void> open() override {
    if (!world_.cable) return fail(ErrorCode::kIo, "no carrier");
    up_ = true;
    host_.deliver("", model::State{model::LineState::kUp, {}, {}});
    for (auto& [address, device] : world_.devices) greet(address, device);
    tick();
    return {};
  }

  Result<void> send(const Message& message) override {
    if (!up_) return fail(ErrorCode::kUnreachable, "no carrier");
    const auto found = world_.devices.find(message.destination.device);
    if (found == world_.devices.end()) return fail(ErrorCode::kNotFound, "no such device");
    auto& [address, device] = *found;
    if (device.silent) return {};  // it does not hear either
    std::uint64_t request = 0;
    if (const auto* sample = std::get_if<model::Sample>(&message.body)) {
      device.sampled = *sample;
      request = sample->request;
    } else if (const auto* actuate = std::get_if<model::Actuate>(&message.body)) {
      device.lamp = std::get<bool>(actuate->value);
      request = actuate->request;
    } else {
      return fail(ErrorCode::kUnsupported, "it has no properties");
    }
    host_.deliver(address, model::Acknowledge{request, model::Outcome::kSent, {}});
    return {};
  }

  void flood(int readings) {
    for (int i = 0; i < readings; ++i) {
      for (auto& [address, device] : world_.devices) report(address, device);
    }
  }
  void lose_cable() {
    up_ = false;
    ticking_.cancel();
    host_.failed({ErrorCode::kIo, "cable pulled"});
  }

 private:
  void greet(const std::string& address, const World::Device& device) {
    if (device.silent) return;
    model::Join join;
    join.capabilities = {Ecology::capability({Kind::kSensor, temperature_, "1"}),
                         Ecology::capability({Kind::kActuator, lamp_, "1"}, model::Access::kReadWrite)};
    host_.deliver(address, join);
    report(address, device);
  }
  void report(const std::string& address, const World::Device& device) {
    host_.deliver(address, model::Updates{{{{Kind::kSensor, temperature_, "1"}, device.temperature, {}},
                                           {{Kind::kActuator, lamp_, "1"}, device.lamp, {}}}});
  }
  void tick() {
    ticking_ = host_.scheduler().after(1s, [this] { tick(); });
    for (auto& [address, device] : world_.devices) {
      if (device.silent) continue;
      device.sampled.points.empty() ? host_.deliver(address, model::KeepAlive{}) : report(address, device);
    }
  }

  World& world_;
  network::NetworkHost& host_;
  TypeId temperature_, lamp_;
  bool up_ = false;
  Timer ticking_;
};

std::map<World*, WorldNetwork*>& present() {
  static std::map<World*, WorldNetwork*> all;
  return all;
}

Result<std::unique_ptr<network::Network>> make_world(const network::NetworkConfig& config, network::NetworkHost& host) {
  config.options.integer("tick", 0);  // an option that a reload changes
  auto& world = worlds()[{number(config.island), config.id}];
  auto made = std::make_unique<WorldNetwork>(world, config.types, host);
  present()[&world] = made.get();
  return made;
}

constexpr network::NetworkType kWorld{
    .name = "world", .summary = "devices that outlive their network", .sample_config = "", .make = &make_world};

/// For ten minutes everything fails that can; then nothing, and everything must be correct again.
class Chaos : public Ecology {
 protected:
  void SetUp() override {
    worlds().clear();
    folder_ = testing::TempDir() + "rubicon-chaos-XXXXXX";
    ASSERT_NE(::mkdtemp(folder_.data()), nullptr);
    for (std::uint32_t island = 1; island <= kIslands; ++island) {
      for (int network = 1; network <= kNetworks; ++network) {
        auto& world = worlds()[{island, "world-" + std::to_string(network)}];
        for (int device = 1; device <= kDevices; ++device) world.devices[std::to_string(device)] = {};
      }
      start(island);
    }
    start_robot();
  }
  void TearDown() override {
    robot_demands_.clear();
    components.clear();
    islands.clear();
    std::filesystem::remove_all(folder_);
  }

  island::IslandConfig config_of(std::uint32_t id, int tick) {
    std::string text = "island: {id: " + std::to_string(id) + ", name: test}\nnetworks:\n";
    for (int network = 1; network <= kNetworks; ++network) {
      text +=
          "  world-" + std::to_string(network) + ": {type: world, silence: 5s, tick: " + std::to_string(tick) + "}\n";
    }
    base::ConfigErrors errors;
    return island::read_island_config(config::parse_yaml(text, "chaos.yaml").value(), std::span(&kWorld, 1), errors);
  }
  void start(std::uint32_t id) {
    base::ConfigErrors errors;
    auto store = state::StateStore::open(folder_ + "/" + std::to_string(id) + ".state", OwnerId(id));
    ASSERT_TRUE(store) << store.error().text;
    auto made = island::Island::make(config_of(id, 0), scheduler, transports, log, ecology, errors, std::move(*store));
    ASSERT_TRUE(made) << made.error().text;
    islands[id] = std::move(*made);
    islands[id]->start();
  }
  void start_robot() {
    auto& space = component(number(kRobot));
    robot_demands_.push_back(space.subscribe({std::nullopt, "proxy.*.*.sensor.*.value"}, {}, [](const Event&) {}));
    robot_demands_.push_back(space.subscribe({std::nullopt, "proxy.**"}, {.passive = true}, [](const Event&) {}));
  }

  World& any_world() {
    auto at = worlds().begin();
    std::advance(at, pick(kIslands * kNetworks));
    return at->second;
  }
  World::Device& any_device() { return any_world().devices[std::to_string(1 + pick(kDevices))]; }
  int pick(int below) { return static_cast<int>(dice_() % static_cast<unsigned>(below)); }
  std::uint32_t any_island() { return 1 + static_cast<std::uint32_t>(pick(kIslands)); }

  void misfortune();
  void command();
  void heal();

  std::string folder_;
  std::vector<Handle> robot_demands_;
  std::mt19937 dice_{20131119};
  std::uint64_t answers_ = 0, commands_ = 0;
};

void Chaos::command() {
  auto& space = component(number(kOperator));
  const auto key = "proxy.world-" + std::to_string(1 + pick(kNetworks)) + "." + std::to_string(1 + pick(kDevices)) +
                   ".actuator.switch-1.command";
  ++commands_;
  space.set_remote(OwnerId(any_island()), key, pick(2) ? "on" : "off", {},
                   [this](const tuples::Reply&) { ++answers_; });
}

void Chaos::misfortune() {
  switch (pick(10)) {
    case 0: {
      auto& world = any_world();
      world.cable = false;
      if (world.host) present()[&world]->lose_cable();
      break;
    }
    case 1: any_world().cable = true; break;
    case 2: any_device().silent = true; break;
    case 3: any_device().silent = false; break;
    case 4:
      if (auto& world = any_world(); world.host && world.cable) present()[&world]->flood(2000);
      break;
    case 5:
      robot_demands_.clear();
      crash(number(kRobot));
      start_robot();
      break;
    case 6: {
      const auto id = any_island();
      islands.erase(id);
      start(id);
      break;
    }
    case 7: ecology.cut(OwnerId(any_island()), pick(2) ? kRobot : kOperator); break;
    case 8: ecology.mend(OwnerId(any_island()), pick(2) ? kRobot : kOperator); break;
    case 9: {
      base::ConfigErrors errors;
      const auto id = any_island();
      EXPECT_TRUE(islands[id]->reload(config_of(id, pick(3)), errors).has_value()) << errors.text();
      break;
    }
  }
}

void Chaos::heal() {
  for (auto& [name, world] : worlds()) {
    world.cable = true;
    for (auto& [address, device] : world.devices) device.silent = false;
  }
  for (std::uint32_t id = 1; id <= kIslands; ++id) {
    for (const auto component : {kRobot, kOperator}) ecology.mend(OwnerId(id), component);
  }
}

TEST_F(Chaos, AfterTenMinutesOfMisfortuneEveryValueIsRightAndNothingGrew) {
  scheduler.run_for(10s);
  std::map<std::uint32_t, std::size_t> own_before;
  for (auto& [id, island] : islands) own_before[id] = island->space().stats().own;
  const auto end = scheduler.now() + 10min;
  while (scheduler.now() < end) {
    misfortune();
    any_device().temperature = static_cast<double>(pick(400)) / 10;
    for (int i = pick(4); i > 0; --i) command();
    scheduler.run_for(std::chrono::milliseconds(100 + pick(2000)));
  }
  heal();
  scheduler.run_for(2min);
  auto& robot = component(number(kRobot));
  for (auto& [name, world] : worlds()) {
    for (auto& [address, device] : world.devices) {
      const auto key = "proxy." + name.second + "." + address;
      EXPECT_EQ(value(robot, name.first, key + ".sensor.temperature-1.value"), to_text(Value(device.temperature)))
          << key;
      EXPECT_EQ(value(robot, name.first, key + ".actuator.switch-1.value"), device.lamp ? "on" : "off") << key;
      EXPECT_EQ(json(robot, name.first, key + ".sensor.temperature-1.status")["quality"], "good") << key;
      EXPECT_EQ(json(robot, name.first, key + ".status")["status"], "reachable") << key;
    }
  }
  EXPECT_EQ(answers_, commands_) << "every command was answered";
  for (auto& [id, island] : islands) {
    const auto stats = island->space().stats();
    EXPECT_EQ(stats.queued, 0U);
    EXPECT_LE(stats.own, own_before[id] + 2 * 16U) << "only counters of the networks may be new";
  }
}

}  // namespace
}  // namespace rubicon::scenarios
