#include "island.h"

#include <stdlib.h>

#include <algorithm>
#include <filesystem>

namespace rubicon::proxy {

TypeCatalogue test_types() {
  TypeCatalogue types;
  const model::SiteType own[] = {
      {.id = 0x8001, .name = "glow", .quantity = "light", .unit = "lx", .minimum = 0, .maximum = 1000, .words = {}},
      {.id = 0x8002, .name = "flap", .quantity = "position", .data = model::DataType::kBoolean, .words = "shut,open"},
      {.id = 0x8003,
       .name = "knob",
       .quantity = "level",
       .data = model::DataType::kInteger,
       .minimum = 0,
       .maximum = 255,
       .words = {}},
      {.id = 0x8004,
       .name = "chime",
       .quantity = "signal",
       .data = model::DataType::kInteger,
       .minimum = 0,
       .maximum = 9,
       .report = model::Report::kEvent,
       .words = {}},
      {.id = 0x8005, .name = "mood", .quantity = "mode", .data = model::DataType::kEnumeration, .words = "day,night"}};
  for (const auto& type : own) EXPECT_TRUE(types.declare(type));
  return types;
}

Result<void> PlayedNetwork::open() {
  if (!line_works) return fail(ErrorCode::kIo, "no carrier");
  if (announces) host_.deliver("", model::State{model::LineState::kUp, {}, {}});
  return {};
}

Result<void> PlayedNetwork::send(const Message& message) {
  sent.push_back(message);
  std::uint64_t request = 0;
  if (const auto* sample = std::get_if<model::Sample>(&message.body)) {
    if (outcome == Outcome::kSent) sampled[message.destination.device] = *sample;
    request = sample->request;
  }
  if (const auto* actuate = std::get_if<model::Actuate>(&message.body)) request = actuate->request;
  if (const auto* property = std::get_if<model::SetProperty>(&message.body)) request = property->request;
  if (answers) host_.deliver(message.destination.device, Acknowledge{request, outcome, why});
  return {};
}

void PlayedNetwork::lose_line() {
  line_works = false;
  host_.failed({ErrorCode::kIo, "cable pulled"});
}

std::map<std::string, PlayedNetwork*>& PlayedNetwork::present() {
  static std::map<std::string, PlayedNetwork*> all;
  return all;
}

Result<std::unique_ptr<network::Network>> PlayedNetwork::make(const network::NetworkConfig& config,
                                                              network::NetworkHost& host) {
  return std::make_unique<PlayedNetwork>(config.id, host);
}

bool LogLines::contain(const std::string& part) const {
  return std::any_of(lines.begin(), lines.end(), [&](const auto& line) { return line.find(part) != line.npos; });
}

Capability capability(Kind kind, TypeId type, const std::string& instance) {
  Capability one;
  one.point = {kind, type, instance};
  one.access = kind == Kind::kSensor ? Access::kRead : Access::kReadWrite;
  return one;
}

model::Updates updates(const PointId& point, Value value, WallTime user_time) {
  return {{{point, std::move(value), user_time}}};
}

Island::Island() {
  rules();
  link = *ecology.join(kIsland);
  robot_link = *ecology.join(kRobot);
  space = std::make_unique<TupleSpace>(kIsland, time, *link);
  robot = std::make_unique<TupleSpace>(kRobot, time, *robot_link);
}

Island::~Island() {
  end();
  if (!state_file_.empty()) std::filesystem::remove_all(std::filesystem::path(state_file_).parent_path());
}

void Island::remember() {
  std::string folder = testing::TempDir() + "rubicon-proxy-XXXXXX";
  ASSERT_NE(::mkdtemp(folder.data()), nullptr);
  state_file_ = folder + "/island.state";
}

void Island::end() {
  networks.reset();
  proxy.reset();
  gate.reset();
  store.reset();
}

void Island::restart() {
  end();
  space.reset();
  link.reset();
  time.run_ready();
  link = *ecology.join(kIsland);
  space = std::make_unique<TupleSpace>(kIsland, time, *link);
  start();
}

void Island::start() {
  if (!state_file_.empty()) {
    auto opened = state::StateStore::open(state_file_, kIsland, state_options);
    ASSERT_TRUE(opened) << opened.error().text;
    store = std::move(*opened);
  }
  gate = std::make_unique<gateway::Gateway>(time, *space, log, limits);
  networks = std::make_unique<network::Supervisor>(kIsland, time, transports, log, *gate);
  gate->connect(*networks);
  proxy = std::make_unique<Proxy>(config, time, *space, *gate, types, log, store.get());
  proxy->restore();
  const network::NetworkType type{.name = "played", .summary = "", .sample_config = "", .make = &PlayedNetwork::make};
  ConfigNode options;
  options.kind = ConfigNode::Kind::kMap;
  ConfigErrors errors;
  ConfigReader reader(options, "networks.hall", errors);
  ASSERT_TRUE(networks->add(type, {"hall", kIsland, reader, types, {}}));
  networks->start();
  time.run_ready();
}

Join Island::lamp() const {
  Join message;
  message.name = "Lamp";
  message.model = "ACME L1";
  message.capabilities = {capability(Kind::kSensor, kGlow, "1"), capability(Kind::kSensor, kGlow, "2"),
                          capability(Kind::kActuator, kFlap, "1")};
  return message;
}

void Island::say(const std::string& device, model::Body body) {
  hall().say(device, std::move(body));
  time.run_ready();
}

void Island::report(const std::string& device, const PointId& point, Value value, WallTime user_time) {
  say(device, updates(point, std::move(value), user_time));
}

std::string Island::text(const std::string& key) const {
  const auto tuple = space->get(kIsland, key);
  EXPECT_TRUE(tuple) << key;
  return tuple ? std::string(tuple->value) : std::string("null");
}

std::string Island::command_state(const std::string& point) const {
  const auto status = json(point + ".status");
  return status.contains("command") ? status["command"]["state"].get<std::string>() : "none";
}

Reply Island::set(const std::string& key, const std::string& value, Duration time_to_live) {
  Reply answer;
  answer.text = "no answer";
  answer.verdict = Verdict::kNoSuchOwner;
  robot->set_remote(kIsland, key, value, time_to_live, [&answer](const Reply& reply) { answer = reply; });
  time.run_ready();
  return answer;
}

}  // namespace rubicon::proxy
