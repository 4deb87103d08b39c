#include "apps/simulators/motes/world.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/assert.h"

namespace rubicon::motes_simulator {

namespace {

constexpr Duration kReopenPause = std::chrono::seconds(1);

/// Independent seeds from one (splitmix64).
std::uint64_t mixed(std::uint64_t seed, std::uint64_t which) {
  std::uint64_t z = seed + which * 0x9e3779b97f4a7c15ULL;
  z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27U)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31U);
}

RadioOptions seeded(RadioOptions options, std::uint64_t seed) {
  options.seed = mixed(seed, 1);
  return options;
}

bool matches(MotePattern pattern, std::uint16_t address, std::uint16_t began_at) {
  return (pattern.address == 0 || pattern.address == address) && (pattern.sink == 0 || pattern.sink == began_at);
}

std::string to_string(MotePattern pattern) {
  const auto address = pattern.address == 0 ? "all" : fmt::format("{}", pattern.address);
  return pattern.sink == 0 ? address : fmt::format("{}@{}", address, pattern.sink);
}

bool is_about_motes(Step::Kind kind) {
  using Kind = Step::Kind;
  constexpr Kind kOthers[] = {Kind::kLoss,       Kind::kDuplicates, Kind::kDelay,
                              Kind::kSinkReboot, Kind::kUnplug,     Kind::kRepeat};
  return std::find(std::begin(kOthers), std::end(kOthers), kind) == std::end(kOthers);
}

std::string addresses(const std::vector<MotePlace>& motes) {
  if (motes.empty()) return "none: there are no motes";
  const auto [lowest, highest] = std::minmax_element(
      motes.begin(), motes.end(), [](const auto& a, const auto& b) { return a.mote.address < b.mote.address; });
  return fmt::format("one of {} to {}", lowest->mote.address, highest->mote.address);
}

}  // namespace

void WorldOptions::add_motes(std::uint16_t at_sink, std::uint16_t first, std::uint16_t count, const MoteOptions& like) {
  for (std::uint16_t i = 0; i < count; ++i) {
    motes.push_back({like, at_sink});
    motes.back().mote.address = static_cast<std::uint16_t>(first + i);
  }
}

World::World(WorldOptions options, Scheduler& scheduler, std::vector<Step> script, EventLog::Callback events)
    : options_(std::move(options)),
      scheduler_(scheduler),
      log_(scheduler, std::move(events)),
      radio_(seeded(options_.radio, options_.seed), scheduler),
      script_(scheduler, std::move(script), [this](const Step& step) { execute(step); }) {
  make_sinks();
  make_motes();
  for (std::uint16_t number = 1; number <= sinks(); ++number) {
    if (!options_.wait_for_computer) boot_motes(number);
  }
  script_.begin();
}

World::~World() = default;

void World::make_sinks() {
  for (std::uint16_t number = 1; number <= options_.sinks; ++number) {
    auto options = options_.sink;
    options.number = number;
    options.seed = mixed(options_.seed, 0x10000U + number);
    auto place = std::make_unique<Place>();
    place->sink = std::make_unique<SinkFirmware>(options, radio_, scheduler_, log_);
    place->port = std::make_unique<SinkPort>(*place->sink, log_);
    place->port->on_connected([this, number] {
      if (options_.wait_for_computer) boot_motes(number);
    });
    place->port->on_closed([this, number] { reopen(number); });
    places_.push_back(std::move(place));
  }
}

void World::make_motes() {
  for (const auto& [wanted, sink] : options_.motes) {
    RUBICON_ASSERT(exists(sink));
    auto options = wanted;
    options.seed = mixed(options_.seed, (std::uint64_t{sink} << 32U) + options.address);
    motes_.push_back(
        {std::make_unique<MoteFirmware>(options, Radio::Cells{sink}, radio_, scheduler_, log_), sink, false, {}});
  }
}

void World::boot_motes(std::uint16_t of_sink) {
  if (std::exchange(places_[of_sink - 1U]->booted, true)) return;
  auto delay = options_.first_boot;
  for (auto& mote : motes_) {
    if (mote.began_at != of_sink || mote.killed) continue;
    mote.boot = scheduler_.after(delay, [firmware = mote.firmware.get()] { firmware->boot(); });
    delay += options_.boot_spacing;
  }
}

Result<void> World::open(std::uint16_t sink, SinkPort::Opener opener) {
  return port(sink).open(std::move(opener));
}

std::vector<World::Mote*> World::matching(MotePattern pattern) {
  std::vector<Mote*> found;
  for (auto& mote : motes_) {
    if (matches(pattern, mote.firmware->address(), mote.began_at)) found.push_back(&mote);
  }
  return found;
}

std::vector<MoteFirmware*> World::motes(MotePattern pattern) {
  std::vector<MoteFirmware*> found;
  for (auto* mote : matching(pattern)) found.push_back(mote->firmware.get());
  return found;
}

MoteFirmware& World::mote(std::uint16_t address, std::uint16_t began_at) {
  const auto found = motes({address, began_at});
  RUBICON_ASSERT(!found.empty());
  return *found.front();
}

void World::unplug(std::uint16_t number, Duration span) {
  if (!exists(number)) return;
  auto& place = *places_[number - 1U];
  if (log_) log_({{}, "unplugged", number, 0, std::nullopt, std::nullopt, {}});
  place.sink->kill();
  place.port->pull();
  place.reopen.cancel();
  place.power_on = std::max(place.power_on, scheduler_.now() + span);
  place.plug_in = scheduler_.at(place.power_on, [this, number] { plug_in(number); });
}

void World::plug_in(std::uint16_t number) {
  sink(number).reboot();
  if (!port(number).plug()) reopen(number);
}

void World::reopen(std::uint16_t number) {
  places_[number - 1U]->reopen = scheduler_.after(kReopenPause, [this, number] {
    if (!port(number).plug()) reopen(number);
  });
}

/// Has no effect while the sink is off.
void World::reboot_sink(std::uint16_t number) {
  if (exists(number) && !places_[number - 1U]->plug_in.pending()) sink(number).reboot();
}

// --- The script.

void World::execute(const Step& step) {
  using Kind = Step::Kind;
  switch (step.kind) {
    case Kind::kLoss: radio_.options().loss = step.to; return;
    case Kind::kDuplicates: radio_.options().duplicates = step.to; return;
    case Kind::kDelay: radio_.options().delay = step.span; return;
    case Kind::kSinkReboot: return reboot_sink(step.sinks.front());
    case Kind::kUnplug: unplug(step.sinks.front(), step.span); return;
    case Kind::kRepeat: return;
    case Kind::kReboot: return reboot(step);
    default:
      for (auto* mote : matching(step.motes)) execute_for(step, *mote);
  }
}

void World::reboot(const Step& step) {
  const auto which = matching(step.motes);
  if (which.empty()) return;
  const auto apart = step.span / static_cast<int>(which.size());
  auto delay = Duration{};
  for (auto* mote : which) {
    auto* const firmware = mote->firmware.get();
    mote->killed = false;
    mote->boot.cancel();
    if (delay == Duration{}) {
      firmware->boot();
    } else {
      mote->boot = scheduler_.after(delay, [firmware] { firmware->boot(); });
    }
    delay += apart;
  }
}

void World::kill(Mote& mote) {
  mote.killed = true;
  mote.boot.cancel();
  mote.firmware->kill();
}

void World::move(const Step& step, MoteFirmware& mote) {
  if (std::all_of(step.sinks.begin(), step.sinks.end(), [this](auto sink) { return exists(sink); }))
    mote.move_to(step.sinks);
}

void World::execute_for(const Step& step, Mote& place) {
  using Kind = Step::Kind;
  using Shape = Signal::Shape;
  auto& mote = *place.firmware;
  const auto show = [&](Shape shape) {
    mote.sensors().show(step.sensor, {shape, step.from, step.to, step.span, scheduler_.now()});
  };
  switch (step.kind) {
    case Kind::kKill: return kill(place);
    case Kind::kStall: mote.stall(); return;
    case Kind::kLossOf: radio_.set_loss(mote.node(), step.to); return;
    case Kind::kSet: return show(Shape::kSet);
    case Kind::kRamp: return show(Shape::kRamp);
    case Kind::kSine: return show(Shape::kSine);
    case Kind::kWalk: return show(Shape::kWalk);
    case Kind::kCount: return show(Shape::kCount);
    case Kind::kMove: return move(step, mote);
    default: return;
  }
}

Result<void> check_script(const std::vector<Step>& script, const WorldOptions& world) {
  for (const auto& step : script) {
    for (const auto sink : step.sinks) {
      if (sink < 1 || sink > world.sinks)
        return fail(ErrorCode::kInvalid,
                    fmt::format("line {}: there is no sink {}, expected 1 to {}", step.line, sink, world.sinks));
    }
    const bool all = step.motes == MotePattern{};
    const bool found = std::any_of(world.motes.begin(), world.motes.end(), [&](const MotePlace& place) {
      return matches(step.motes, place.mote.address, place.sink);
    });
    if (is_about_motes(step.kind) && !all && !found)
      return fail(ErrorCode::kInvalid, fmt::format("line {}: there is no mote {}, expected {}", step.line,
                                                   to_string(step.motes), addresses(world.motes)));
  }
  return {};
}

}  // namespace rubicon::motes_simulator
