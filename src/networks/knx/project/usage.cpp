#include "networks/knx/project/usage.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

namespace rubicon::networks::knx::project {

namespace {

constexpr auto kMainOnly = dpt::DptId::kMainOnly;

std::optional<dpt::DptId> type_of_size(std::string_view size) {
  if (size == "1 Bit") return dpt::DptId{1, kMainOnly};
  if (size == "2 Bit") return dpt::DptId{2, kMainOnly};
  if (size == "4 Bit") return dpt::DptId{3, kMainOnly};
  return std::nullopt;
}

std::string list_text(const std::vector<dpt::DptId>& types) {
  constexpr std::size_t kShown = 6;
  std::string out;
  for (std::size_t i = 0; i < types.size() && i < kShown; ++i)
    out += fmt::format("{}{}", i == 0 ? "" : ", ", to_string(types[i]));
  return types.size() > kShown ? out + ", ..." : out;
}

}  // namespace

void add_type(std::vector<dpt::DptId>& types, dpt::DptId type) {
  if (types.size() < kMaxTypes && std::find(types.begin(), types.end(), type) == types.end()) types.push_back(type);
}

std::vector<dpt::DptId> object_types(std::string_view types, std::string_view size) {
  std::vector<dpt::DptId> all;
  while (true) {
    types.remove_prefix(std::min(types.find_first_not_of(" ,\n"), types.size()));
    if (types.empty()) break;
    const auto word = types.substr(0, types.find_first_of(" ,\n"));
    types.remove_prefix(word.size());
    const auto id = dpt::parse_dpt(word);
    const auto* known = id ? dpt::find_dpt(*id) : nullptr;
    if (known != nullptr) add_type(all, known->id.sub == kMainOnly ? known->id : *id);
  }
  if (const auto by_size = all.empty() ? type_of_size(size) : std::nullopt) all.push_back(*by_size);
  return all;
}

ChosenType type_of(std::optional<dpt::DptId> own, const std::vector<dpt::DptId>& of_objects) {
  if (own && own->sub != kMainOnly) return {own, {}};
  std::vector<dpt::DptId> types;
  for (const auto type : of_objects) {
    if (!own || type.main == own->main) add_type(types, type);
  }
  if (types.empty()) return {own, {}};
  if (types.size() == 1) return {types.front(), {}};
  const auto main = types.front().main;
  const bool one_main = std::all_of(types.begin(), types.end(), [&](dpt::DptId type) { return type.main == main; });
  if (own) return {own, {}};
  std::sort(types.begin(), types.end());
  if (one_main)
    return {dpt::DptId{main, kMainOnly},
            fmt::format("its objects have the types {}: imported with main type {}", list_text(types), main)};
  return {std::nullopt, fmt::format("its objects have the types {}: imported without a type", list_text(types))};
}

namespace {

using groups::Use;

/// Larger channels and functions are not searched for pairs: each member is compared with each other.
constexpr std::size_t kMaxCompared = 256;

/// The pairs of command and state addresses that one source finds.
class States {
 public:
  explicit States(std::size_t count) : found_(count), doubtful_(count) {}

  void add(std::size_t command, std::size_t state) {
    if (command == state) return;
    if (found_[command] && *found_[command] != state) doubtful_[command] = true;
    found_[command] = state;
  }

  /// Adds the pairs that are beyond doubt; what an earlier source settled stays.
  void settle(std::vector<std::optional<std::size_t>>& states) {
    std::map<std::size_t, std::size_t> commands_of;
    for (std::size_t i = 0; i < found_.size(); ++i) {
      if (found_[i] && !doubtful_[i]) ++commands_of[*found_[i]];
    }
    std::set<std::size_t> taken;
    for (std::size_t i = 0; i < states.size(); ++i) {
      if (states[i]) taken.insert({i, *states[i]});
    }
    for (std::size_t i = 0; i < found_.size(); ++i) {
      const bool sound = found_[i] && !doubtful_[i] && commands_of[*found_[i]] == 1 && !commands_of.contains(i);
      if (sound && !taken.contains(i) && !taken.contains(*found_[i])) states[i] = found_[i];
    }
  }

 private:
  std::vector<std::optional<std::size_t>> found_;
  std::vector<bool> doubtful_;
};

/// `InfoOnOff` -> `OnOff`: what the role reports; empty = it does not report.
std::string_view reported_by(std::string_view role) {
  for (const std::string_view begin : {"Info", "Current"}) {
    if (role.starts_with(begin)) return role.substr(begin.size());
  }
  return {};
}

void add_function(const Members& members, States& states, std::vector<Use>& uses) {
  for (const auto& [state, role] : members) {
    const auto what = reported_by(role);
    if (what.empty()) continue;
    uses[state] = Use::kReported;
    if (members.size() > kMaxCompared) continue;
    std::vector<std::size_t> commands;
    for (const auto& [address, other] : members) {
      if (reported_by(other).empty() && std::string_view(other).ends_with(what)) commands.push_back(address);
    }
    if (commands.size() == 1) states.add(commands.front(), state);
  }
}

bool same_main(const BusObject& a, const BusObject& b, const std::vector<groups::GroupEntry>& entries) {
  const auto& one = entries[a.addresses.front()].dpt;
  const auto& other = entries[b.addresses.front()].dpt;
  return one && other && one->main == other->main;
}

/// True if the texts say the same but for words of state and command. Set and actual values are the same too, but for
/// numbers that are measured (main types 9 and 14).
bool same_thing(const BusObject& a, const BusObject& b, std::uint16_t main) {
  return a.words->rest == b.words->rest || (main != 9 && main != 14 && a.words->stem == b.words->stem);
}

/// Objects of one channel of one device.
void add_channel(const std::vector<const BusObject*>& objects, const std::vector<groups::GroupEntry>& entries,
                 States& states) {
  for (const auto* command : objects) {
    if (!command->takes()) continue;
    std::vector<const BusObject*> reports;
    for (const auto* other : objects) {
      if (other->reports() && same_main(*command, *other, entries) &&
          same_thing(*command, *other, entries[command->addresses.front()].dpt->main))
        reports.push_back(other);
    }
    if (reports.size() == 1) states.add(command->addresses.front(), reports.front()->addresses.front());
  }
}

std::vector<Use> uses_by_flags(const std::vector<BusObject>& objects, std::size_t count) {
  std::vector<bool> unknown(count), taken(count), reported(count);
  for (const auto& object : objects) {
    for (const auto address : object.addresses) {
      unknown[address] = unknown[address] || !object.flags_known;
      taken[address] = taken[address] || object.takes();
    }
    if (object.reports()) reported[object.addresses.front()] = true;
  }
  std::vector<Use> uses(count);
  for (std::size_t i = 0; i < count; ++i) {
    if (unknown[i]) continue;
    if (taken[i]) uses[i] = reported[i] ? Use::kShared : Use::kCommanded;
    if (!taken[i] && reported[i]) uses[i] = Use::kReported;
  }
  return uses;
}

}  // namespace

Usage usage_of(const std::vector<BusObject>& objects, const std::vector<groups::GroupEntry>& entries,
               const std::vector<Members>& functions) {
  Usage usage;
  usage.uses = uses_by_flags(objects, entries.size());
  usage.states.resize(entries.size());
  States by_function(entries.size());
  for (const auto& members : functions) add_function(members, by_function, usage.uses);
  by_function.settle(usage.states);
  std::map<std::pair<std::size_t, std::string_view>, std::vector<const BusObject*>> channels;
  for (const auto& object : objects) {
    if (!object.channel.empty()) channels[{object.device, object.channel}].push_back(&object);
  }
  States by_flags(entries.size());
  for (const auto& [channel, members] : channels) {
    if (members.size() <= kMaxCompared) add_channel(members, entries, by_flags);
  }
  by_flags.settle(usage.states);
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (!usage.states[i]) continue;
    usage.uses[i] = Use::kCommanded;
    usage.uses[*usage.states[i]] = Use::kReported;
  }
  return usage;
}

}  // namespace rubicon::networks::knx::project
