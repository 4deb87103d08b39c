#include "apps/simulators/zigbee/simulator.h"

#include <fmt/format.h>

#include <array>

namespace rubicon::zigbee_simulator {

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
    for (const auto& member : line.members) members.push_back(world_.find(member)->address());
    world_.add_group(line.id, line.name, std::move(members));
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
    case Kind::kSay: return world_.say(step.word, step.text);
    case Kind::kStop: return world_.restart(step.span);
    case Kind::kRepeat: return;
    default: break;
  }
  auto* device = world_.find(step.name);
  if (device == nullptr) return log_.warning(fmt::format("line {}: {} is not there any longer", step.line, step.name));
  if (world_.runs()) take_of(*device, step);
}

void Simulator::take_of(RadioDevice& device, const Step& step) {
  using Kind = Step::Kind;
  switch (step.kind) {
    case Kind::kSet: return world_.change(device, step.word, value_of_word(step.text));
    case Kind::kAction: return world_.act(device, "action", value_of_word(step.text));
    case Kind::kReport: return world_.report(device);
    case Kind::kFault: return set_fault(device, step.word);
    case Kind::kDelay: device.faults.delay = step.span; return;
    case Kind::kUnknown: return world_.change(device, step.word, nullptr);
    case Kind::kLeave: return world_.leave(device.address());
    case Kind::kAnnounce: return world_.announce(device);
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
  world_.set_faults(device, faults);
}

}  // namespace rubicon::zigbee_simulator
