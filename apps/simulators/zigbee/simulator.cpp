#include "apps/simulators/zigbee/simulator.h"

#include <fmt/format.h>

#include <array>

namespace rubicon::zigbee_simulator {

namespace {

using namespace std::chrono_literals;

/// A real bridge tries again each second.
constexpr Duration kBetweenAttempts = 1s;

}  // namespace

BrokerLine::BrokerLine(World& world, transport::MqttOptions options, Scheduler& scheduler,
                       transport::Transports& transports, Log log)
    : world_(world),
      options_(std::move(options)),
      scheduler_(scheduler),
      transports_(transports),
      log_(std::move(log)) {
  options_.will = transport::MqttWill{world.options().base + "/bridge/state", R"({"state":"offline"})", true};
  world_.topics().publish = [this](transport::MqttPublication publication) { send(std::move(publication)); };
  world_.registry().named = [this](const std::string& name, bool used) { named(name, used); };
}

BrokerLine::~BrokerLine() {
  world_.topics().publish = nullptr;
  world_.registry().named = nullptr;
}

Result<void> BrokerLine::open() {
  transport::MqttCallbacks calls;
  calls.connected = [this](const transport::MqttConnack&) { on_connected(); };
  calls.received = [this](const transport::MqttMessage& message) {
    if (!message.retained) world_.received(message.topic, message.payload);
  };
  calls.refused = [this](std::string_view filter, const Error& why) {
    log_.error(fmt::format("the broker refuses the subscription to {}: {}", filter, why.text));
  };
  calls.failed = [this](const Error& why) { failed(why); };
  auto opened = transports_.open_mqtt(options_, std::move(calls));
  if (!opened) return fail(opened.error());
  line_ = std::move(*opened);
  return {};
}

void BrokerLine::on_connected() {
  connected_ = true;
  last_error_.clear();
  log_.info(fmt::format("connected to {}:{}", options_.host, options_.port));
  listen();
  if (std::exchange(had_started_, true)) return world_.reconnected();
  world_.start();
  if (started) started();
}

void BrokerLine::failed(const Error& why) {
  connected_ = false;
  line_.reset();
  if (why.text != last_error_) log_.error(why.text);
  last_error_ = why.text;
  again_ = scheduler_.after(kBetweenAttempts, [this] {
    if (const auto opened = open(); !opened) failed(opened.error());
  });
}

/// The filters of one name: `NAME/set/#` is for `NAME/set` too.
void BrokerLine::named(const std::string& name, bool used) {
  if (used) {
    names_.insert(name);
  } else {
    names_.erase(name);
  }
  if (!connected_) return;
  for (const auto* verb : {"/set/#", "/get/#"}) {
    const auto filter = world_.options().base + "/" + name + verb;
    const auto asked = used ? line_->subscribe(filter) : line_->unsubscribe(filter);
    if (!asked) log_.error(asked.error().text);
  }
}

void BrokerLine::listen() {
  if (const auto asked = line_->subscribe(world_.options().base + "/bridge/request/#"); !asked)
    log_.error(asked.error().text);
  for (const auto& name : std::set<std::string>(names_)) named(name, true);
}

void BrokerLine::send(transport::MqttPublication publication) {
  const auto sent = connected_ ? line_->publish(std::move(publication)) : fail(ErrorCode::kUnreachable, "no broker");
  if (!sent) ++lost_;
}

Simulator::Simulator(SimulatorOptions options, Script script, Scheduler& scheduler, transport::Transports& transports,
                     Log log)
    : options_(std::move(options)),
      file_(std::move(script)),
      log_(log),
      world_(options_.world, scheduler, log),
      line_(world_, options_.broker, scheduler, transports, log),
      generator_(options_.world.seed),
      script_(scheduler, std::move(file_.steps), [this](const Step& step) { take(step); }) {}

DeviceModel Simulator::model_of(const std::string& name) {
  auto built_in = find_model(name);
  return built_in ? std::move(*built_in) : make_model(generator_, generated_++);
}

Result<RadioDevice*> Simulator::add(const std::string& model, std::string name) {
  return world_.add(model_of(model), std::move(name));
}

Result<void> Simulator::open() {
  for (const auto& line : file_.devices) {
    const auto device = add(line.model, line.name);
    if (!device) return fail(device.error());
    if (line.every > Duration{}) (*device)->every = line.every;
  }
  const auto models = model_names();
  for (int i = 0; i < options_.devices; ++i) {
    const auto& model = models[static_cast<std::size_t>(i) % models.size()];
    if (const auto added = add(model, fmt::format("{} {}", model, i + 1)); !added) return fail(added.error());
  }
  for (int i = 0; i < options_.generated; ++i) {
    if (const auto added = add("random", ""); !added) return fail(added.error());
  }
  for (const auto& line : file_.groups) {
    std::vector<std::string> members;
    for (const auto& member : line.members) members.push_back(world_.registry().find(member)->address());
    world_.registry().add_group(line.id, line.name, std::move(members));
  }
  line_.started = [this] {
    script_.begin();
    if (connected) connected();
  };
  return line_.open();
}

void Simulator::burst(int count) {
  for (int i = 0; i < count; ++i) world_.join(model_of("random"));
}

void Simulator::take(const Step& step) {
  using Kind = Step::Kind;
  switch (step.kind) {
    case Kind::kPermit: return world_.permit_join(step.span);
    case Kind::kJoin:
    case Kind::kFail: world_.join(model_of(step.word), step.kind == Kind::kFail); return;
    case Kind::kBurst: return burst(step.count);
    case Kind::kSay: return world_.topics().say(step.word, step.text);
    case Kind::kStop: return world_.restart(step.span);
    case Kind::kRepeat: return;
    default: break;
  }
  auto* device = world_.registry().find(step.name);
  if (device == nullptr) return log_.warning(fmt::format("line {}: {} is not there any longer", step.line, step.name));
  if (world_.runs()) take_of(*device, step);
}

void Simulator::take_of(RadioDevice& device, const Step& step) {
  using Kind = Step::Kind;
  switch (step.kind) {
    case Kind::kSet: return world_.radio().change(device, step.word, value_of_word(step.text));
    case Kind::kAction: return world_.radio().act(device, "action", value_of_word(step.text));
    case Kind::kReport: return world_.radio().report(device);
    case Kind::kFault: return set_fault(device, step.word);
    case Kind::kDelay: device.faults.delay = step.span; return;
    case Kind::kUnknown: return world_.radio().change(device, step.word, nullptr);
    case Kind::kLeave: return world_.leave(device.address());
    case Kind::kAnnounce: return world_.radio().announce(device);
    case Kind::kShorten: return world_.shrink_list({device.address()});
    case Kind::kRename:
      if (const auto renamed = world_.rename(device, step.word); !renamed) log_.warning(renamed.error().text);
      return;
    default: return;
  }
}

void Simulator::set_fault(RadioDevice& device, const std::string& word) {
  auto faults = word == "none" ? Faults{} : device.faults;
  if (word == "ignore") faults.ignores = true;
  if (word == "refuse") faults.refuses = true;
  if (word == "silent") faults.silent = true;
  if (word == "echo-first") faults.echo_first = true;
  world_.radio().set_faults(device, faults);
}

}  // namespace rubicon::zigbee_simulator
