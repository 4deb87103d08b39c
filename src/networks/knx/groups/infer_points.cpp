#include "networks/knx/groups/infer_points.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <initializer_list>
#include <map>

#include "networks/knx/groups/words.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::knx::groups {

namespace {

struct Rule {
  std::uint16_t main, first, last;
  Kind kind;
};
constexpr Kind kSensor = Kind::kSensor, kActuator = Kind::kActuator;
constexpr std::uint16_t kAll = dpt::DptId::kMainOnly;

/// The first matching rule decides; types without a rule are sensors (4, 6, 8, 10 to 16, 19, 24 to 29, ...).
constexpr std::array kRules{
    Rule{1, 5, 6, kSensor},           // alarm, binary value
    Rule{1, 11, 11, kSensor},         // state
    Rule{1, 14, 14, kSensor},         // input source
    Rule{1, 18, 19, kSensor},         // occupancy, window and door
    Rule{1, 1200, 1201, kSensor},     // consumer or producer, direction of energy
    Rule{1, 0, kAll, kActuator},      // switches and everything like them
    Rule{2, 0, kAll, kActuator},      // forced control
    Rule{3, 0, kAll, kActuator},      // relative dimming, blinds
    Rule{5, 4, 6, kSensor},           // percent of 255, factor, tariff
    Rule{5, 10, 10, kSensor},         // counter
    Rule{5, 0, kAll, kActuator},      // brightness, position, angle, fan stage
    Rule{7, 600, 600, kActuator},     // colour temperature
    Rule{17, 0, kAll, kActuator},     // scenes
    Rule{18, 0, kAll, kActuator},     //
    Rule{20, 6, 7, kSensor},          // area of application, class of alarm
    Rule{20, 11, 12, kSensor},        // classes of errors
    Rule{20, 14, 14, kSensor},        // wind force
    Rule{20, 20, 21, kSensor},        // type of actuator, clouds
    Rule{20, 100, 101, kSensor},      // fuel, burner
    Rule{20, 113, 114, kSensor},      // status of the setpoint, kind of meter
    Rule{20, 120, 120, kSensor},      // kind of damper
    Rule{20, 610, 610, kSensor},      // load found
    Rule{20, 1001, 1001, kSensor},    // additional information
    Rule{20, 1004, 1004, kSensor},    // medium
    Rule{20, 1200, 1221, kSensor},    // meters, charging stations
    Rule{20, 60102, 60102, kSensor},  // HVAC status
    Rule{20, 0, kAll, kActuator},     // modes
    Rule{21, 2, 2, kActuator},        // device control
    Rule{21, 100, 101, kActuator},    // forcing signals
    Rule{21, 1010, 1010, kActuator},  // activation of channels
    Rule{22, 1010, 1010, kActuator},  //
    Rule{30, 1010, 1010, kActuator},  //
    Rule{23, 2, 2, kSensor},          // reaction to an alarm
    Rule{23, 0, kAll, kActuator},     // two-bit actions
    Rule{206, 0, kAll, kActuator},    // the next mode
    Rule{213, 0, kAll, kActuator},    // sets of setpoints
    Rule{222, 0, kAll, kActuator},    //
    Rule{275, 0, kAll, kActuator},    //
    Rule{225, 1, 2, kActuator},       // scaling in a time
    Rule{232, 0, kAll, kActuator},    // colours
    Rule{236, 0, kAll, kActuator},    // mode with priority
    Rule{238, 1, 1, kActuator},       // configuration of scenes
    Rule{239, 0, kAll, kActuator},    // scaling with a flag
    Rule{240, 0, kAll, kActuator},    // position of blind and slat
    Rule{242, 0, kAll, kActuator},    // colours, and how they change
    Rule{243, 0, kAll, kActuator},    //
    Rule{249, 0, kAll, kActuator},    //
    Rule{250, 0, kAll, kActuator},    //
    Rule{251, 0, kAll, kActuator},    //
    Rule{252, 0, kAll, kActuator},    //
    Rule{253, 0, kAll, kActuator},    //
    Rule{254, 0, kAll, kActuator},    //
};

}  // namespace

Kind kind_of_type(std::optional<dpt::DptId> type) {
  if (!type) return kSensor;
  for (const auto& rule : kRules) {
    if (rule.main == type->main && type->sub >= rule.first && type->sub <= rule.last) return rule.kind;
  }
  return kSensor;
}

namespace {

struct Named {
  const GroupEntry* entry = nullptr;
  NameWords words;
  const Named* state = nullptr;  ///< of an actuator: its state address
  bool is_state = false;         ///< it is the state address of another one
  bool undecided = false;
};

/// Addresses that could belong together.
struct Candidates {
  std::vector<Named*> commands, states;
};

std::string group_key(const GroupEntry& entry, std::string_view name) {
  return fmt::format("{}\n{}\n{}\n{}", entry.dpt->main, entry.main_group, entry.middle_group, name);
}

/// What the flags of its objects decide; nullopt: nothing. Without a type it stays a sensor (kind_of_type()).
std::optional<Kind> kind_by_use(const GroupEntry& entry) {
  if (entry.use == Use::kReported) return Kind::kSensor;
  if (entry.use == Use::kCommanded && entry.dpt) return Kind::kActuator;
  return std::nullopt;
}

/// True if it reports a state, by its name; never what devices take as a command.
bool is_report(const Named& named, std::initializer_list<Sense> senses) {
  return named.entry->use != Use::kCommanded &&
         std::any_of(senses.begin(), senses.end(), [&](Sense sense) { return named.words.means(sense); });
}

/// True if it could be commanded, by its objects, its type or its name.
bool is_command(const Named& named) {
  const auto& words = named.words;
  if (const auto by_use = kind_by_use(*named.entry)) return *by_use == Kind::kActuator;
  const bool by_word = words.means(Sense::kCommand) || words.means(Sense::kSetpoint) || words.means(Sense::kSwitch);
  return !words.means(Sense::kMeasured) && (by_word || kind_of_type(named.entry->dpt) == Kind::kActuator);
}

/// `Lamp switch` and `Lamp status`, `Setpoint` and `Setpoint status`.
void by_state_word(Named& named, std::map<std::string, Candidates>& out) {
  const bool reports = is_report(named, {Sense::kState});
  if (!reports && !is_command(named)) return;
  auto& group = out[group_key(*named.entry, named.words.rest)];
  (reports ? group.states : group.commands).push_back(&named);
}

/// `Blind Sollwert` and `Blind Istwert`. Not for main types 9 and 14: their actual values are measurements.
void by_actual_word(Named& named, std::map<std::string, Candidates>& out) {
  const auto& words = named.words;
  const auto main = named.entry->dpt->main;
  if (named.state || named.is_state || main == 9 || main == 14) return;
  const bool reports = is_report(named, {Sense::kActual, Sense::kState});
  const bool by_word = words.means(Sense::kCommand) || words.means(Sense::kSwitch) || words.means(Sense::kSetpoint);
  const bool commands = by_word && named.entry->use != Use::kReported;
  if ((reports && words.means(Sense::kSetpoint)) || (!reports && !commands)) return;
  auto& group = out[group_key(*named.entry, words.stem)];
  (reports ? group.states : group.commands).push_back(&named);
}

/// Of several commands the one with the same type as the state, else the one with a command word.
void narrow(std::vector<Named*>& commands, const Named& state) {
  const auto keep = [&](auto test) {
    if (commands.size() > 1 && std::count_if(commands.begin(), commands.end(), test) == 1) {
      std::erase_if(commands, [&](const Named* command) { return !test(command); });
    }
  };
  keep([&](const Named* command) { return command->entry->dpt == state.entry->dpt; });
  keep([](const Named* command) {
    return command->words.means(Sense::kCommand) || command->words.means(Sense::kSwitch);
  });
}

std::string shown(const Named& named, wire::Notation notation) {
  return fmt::format("{} '{}'", to_string(named.entry->address, notation), named.entry->name);
}

class Guesser {
 public:
  Guesser(const std::vector<GroupEntry>& entries, Report& report) : report_(report) {
    all_.reserve(entries.size());
    for (const auto& entry : entries) all_.push_back({&entry, words_of(entry.name)});
  }

  /// Pairs addresses by functions and objects of a project, before names are used.
  void pair_by_project() {
    std::map<wire::GroupAddress, Named*> by_address;
    for (auto& named : all_) by_address.emplace(named.entry->address, &named);
    for (auto& named : all_) {
      if (!named.entry->state || !named.entry->dpt) continue;
      const auto found = by_address.find(*named.entry->state);
      if (found == by_address.end()) continue;
      auto& state = *found->second;
      const bool fits = state.entry->dpt && state.entry->dpt->main == named.entry->dpt->main;
      if (!fits || &state == &named || state.is_state || state.state || named.is_state) continue;
      ++report_.paired_by_project;
      join(named, state, "by the project");
    }
  }

  void pair() {
    for (const auto rule : {by_state_word, by_actual_word}) {
      std::map<std::string, Candidates> groups;
      for (auto& named : all_) {
        if (named.entry->dpt) rule(named, groups);
      }
      for (auto& [key, group] : groups) decide(group);
    }
  }

  Kind kind(const Named& named) {
    const auto by_type = kind_of_type(named.entry->dpt);
    if (const auto by_use = kind_by_use(*named.entry)) return by_project(*named.entry, *by_use, by_type);
    const auto by_name = named.entry->dpt ? kind_by_name(named, by_type) : by_type;
    if (by_name != by_type) {
      ++report_.kinds_by_name;
      report_.note(named.entry->line, named.entry->address,
                   fmt::format("inferred: '{}' is {} by its name ({}), by its type it would be {}", named.entry->name,
                               article(by_name), named.words.shown, article(by_type)));
    }
    return by_name;
  }

  /// Without names.
  Kind kind_of_facts(const Named& named) {
    const auto by_type = kind_of_type(named.entry->dpt);
    return by_project(*named.entry, kind_by_use(*named.entry).value_or(by_type), by_type);
  }

  const std::vector<Named>& all() const { return all_; }

 private:
  static std::string_view article(Kind kind) { return kind == Kind::kActuator ? "an actuator" : "a sensor"; }

  Kind by_project(const GroupEntry& entry, Kind kind, Kind by_type) {
    if (kind == by_type) return kind;
    ++report_.kinds_by_project;
    report_.note(entry.line, entry.address,
                 fmt::format("'{}' is {} by the objects that use it, by its type it would be {}", entry.name,
                             article(kind), article(by_type)));
    return kind;
  }

  void join(Named& command, Named& state, std::string_view why) {
    command.state = &state;
    state.is_state = true;
    report_.note(command.entry->line, command.entry->address,
                 fmt::format("{}: '{}' reports on {}", why, command.entry->name, shown(state, report_.notation)));
  }

  static Kind kind_by_name(const Named& named, Kind otherwise) {
    const auto& words = named.words;
    if (named.state) return Kind::kActuator;
    if (words.means(Sense::kState)) return Kind::kSensor;
    if (words.means(Sense::kSetpoint) || words.means(Sense::kCommand)) return Kind::kActuator;
    return words.means(Sense::kActual) || words.means(Sense::kMeasured) ? Kind::kSensor : otherwise;
  }

  void decide(Candidates& group) {
    std::erase_if(group.commands, [](const Named* named) { return named->state || named->is_state; });
    std::erase_if(group.states, [](const Named* named) { return named->is_state; });
    if (group.commands.empty() || group.states.empty()) return;
    if (group.states.size() == 1) narrow(group.commands, *group.states.front());
    if (group.commands.size() > 1 || group.states.size() > 1) return undecided(group);
    ++report_.paired;
    join(*group.commands.front(), *group.states.front(), "inferred");
  }

  void undecided(const Candidates& group) {
    std::string others;
    for (const auto* state : group.states) {
      if (others.size() < 200)
        others += fmt::format("{}{}", others.empty() ? "" : ", ", shown(*state, report_.notation));
    }
    for (auto* command : group.commands) {
      if (command->undecided) continue;
      command->undecided = true;
      report_.note(command->entry->line, command->entry->address,
                   fmt::format("not paired: '{}' may report on {}, but {} addresses fit", command->entry->name, others,
                               group.commands.size() + group.states.size()));
    }
  }

  Report& report_;
  std::vector<Named> all_;
};

GroupPoint point_of(const GroupEntry& entry, Kind kind) {
  GroupPoint point;
  point.address = entry.address;
  point.dpt = entry.dpt;
  point.kind = kind;
  point.name = entry.name;
  point.description = entry.description.empty() ? entry.function : entry.description;
  point.room = entry.room;
  point.main_group = entry.main_group;
  point.middle_group = entry.middle_group;
  return point;
}

/// Why a point cannot take its value from another address; empty if it can.
std::string_view why_not_heard(const GroupPoint& point, const GroupEntry& other) {
  if (!point.dpt || !other.dpt) return "the type of one of both is not known";
  return other.dpt->main == point.dpt->main ? std::string_view() : "it has another main type";
}

/// The listening addresses of an ESF that have the same main type.
void take_listen(const std::vector<GroupEntry>& entries, std::vector<GroupPoint>& points, Report& report) {
  std::map<wire::GroupAddress, const GroupEntry*> by_address;
  for (const auto& entry : entries) by_address.emplace(entry.address, &entry);
  for (auto& point : points) {
    const auto& entry = *by_address.at(point.address);
    for (const auto address : entry.listen) {
      if (address == point.address || address == point.state) continue;
      const auto other = by_address.find(address);
      const auto why = other == by_address.end() ? "it is not in the file" : why_not_heard(point, *other->second);
      if (why.empty()) {
        point.listen.push_back(address);
      } else {
        report.warning(entry.line, point.address,
                       fmt::format("listening address {} left out: {}", to_string(address, report.notation), why));
      }
    }
  }
}

}  // namespace

std::vector<GroupPoint> infer_points(const std::vector<GroupEntry>& entries, bool by_name, Report& report) {
  std::vector<GroupPoint> points;
  points.reserve(entries.size());
  Guesser guesser(entries, report);
  guesser.pair_by_project();
  if (by_name) guesser.pair();
  for (const auto& named : guesser.all()) {
    if (named.is_state) continue;
    points.push_back(point_of(*named.entry, by_name ? guesser.kind(named) : guesser.kind_of_facts(named)));
    if (!named.state) continue;
    points.back().state = named.state->entry->address;
    points.back().state_name = named.state->entry->name;
  }
  take_listen(entries, points, report);
  std::sort(points.begin(), points.end(), [](const auto& a, const auto& b) { return a.address < b.address; });
  return points;
}

}  // namespace rubicon::networks::knx::groups
