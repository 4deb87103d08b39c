#include "island/reload_plan.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <string.h>  // NOLINT(modernize-deprecated-headers): explicit_bzero

#include <algorithm>
#include <filesystem>
#include <map>
#include <string_view>

#include "base/bytes.h"

namespace rubicon::island {

namespace {

using proxy::DeviceNames;
using proxy::NetworkRules;

/// Paths or devices named in one line.
constexpr std::size_t kNamed = 8;

const NetworkSetup* find(const std::vector<NetworkSetup>& networks, const std::string& id) {
  const auto found = std::find_if(networks.begin(), networks.end(), [&](const auto& setup) { return setup.id == id; });
  return found == networks.end() ? nullptr : &*found;
}

std::string list(std::vector<std::string> names) {
  const bool more = names.size() > kNamed;
  if (more) names.resize(kNamed);
  return fmt::format("{}{}", fmt::join(names, ", "), more ? ", ..." : "");
}

/// The node at a path as base::differences() writes it; nullptr if it is not there.
const ConfigNode* node_at(const ConfigNode& node, std::string_view path) {
  if (path.starts_with('.')) path.remove_prefix(1);
  if (path.empty()) return &node;
  for (std::size_t i = 0; i < node.items.size(); ++i) {
    const auto index = fmt::format("[{}]", i);
    if (path.starts_with(index)) return node_at(node.items[i], path.substr(index.size()));
  }
  for (const auto& [key, child] : node.entries) {
    const auto rest = path.substr(std::min(key.size(), path.size()));
    if (!path.starts_with(key) || (!rest.empty() && rest.front() != '.' && rest.front() != '[')) continue;
    if (const auto* found = node_at(child, rest)) return found;
  }
  return nullptr;
}

/// `home.yaml:2:9: `; empty where the new file has neither the path nor the section.
std::string place_text(const ConfigNode& section, std::string_view path) {
  const auto* node = node_at(section, path);
  const auto place = to_string((node ? *node : section).key_place());
  return place.empty() ? place : place + ": ";
}

/// One refusal for each path in which a section differs that a running island cannot change.
void refuse_changes(const std::string& section, const ConfigNode& now, const ConfigNode& next, ReloadPlan& plan) {
  for (const auto& path : base::differences(now, next, kNamed)) {
    const auto full = path.empty() ? section : fmt::format("{}.{}", section, path);
    plan.refusals.push_back(
        fmt::format("{}{}: a running island cannot change this; restart it", place_text(next, path), full));
  }
}

std::vector<std::string> renamed_devices(const NetworkRules& now, const NetworkRules& next) {
  std::vector<std::string> addresses;
  const auto names_in = [](DeviceNames names) {
    names.valid.clear();
    return names;
  };
  const auto compare = [&](const NetworkRules& these, const NetworkRules& those, bool both) {
    for (const auto& [address, device] : these.devices) {
      const auto names = names_in(device);
      const auto other = those.devices.find(address);
      const bool differs =
          other == those.devices.end() ? !(names == DeviceNames{}) : both && !(names_in(other->second) == names);
      if (differs) addresses.push_back(address);
    }
  };
  compare(next, now, true);
  compare(now, next, false);
  return addresses;
}

std::map<std::string, std::map<std::string, proxy::Valid>> limits_in(const NetworkRules& rules) {
  std::map<std::string, std::map<std::string, proxy::Valid>> limits{{std::string(), rules.valid}};
  for (const auto& [address, device] : rules.devices) {
    if (!device.valid.empty()) limits[address] = device.valid;
  }
  return limits;
}

void compare_rules(const std::string& id, const NetworkRules& now, const NetworkRules& next, ReloadPlan& plan) {
  if (now.silence != next.silence) plan.lines.push_back(fmt::format("network {}: silence changes", id));
  if (now.rate != next.rate) {
    plan.lines.push_back(
        fmt::format("network {}: rate changes from {} ms to {} ms", id, now.rate.count(), next.rate.count()));
  }
  if (now.roaming != next.roaming) {
    const auto word = [](const std::string& domain) { return domain.empty() ? std::string("off") : domain; };
    plan.lines.push_back(
        fmt::format("network {}: roaming changes from {} to {}", id, word(now.roaming), word(next.roaming)));
  }
  if (limits_in(now) != limits_in(next))
    plan.lines.push_back(fmt::format("network {}: the limits of plausible values change", id));
  const auto renamed = renamed_devices(now, next);
  if (!renamed.empty()) {
    plan.lines.push_back(fmt::format("network {}: {} devices are renamed: {}", id, renamed.size(), list(renamed)));
  }
}

/// Networks that only have another id, such as those of a list when one before them is removed.
void find_renamed(const IslandConfig& now, const IslandConfig& next, ReloadPlan& plan) {
  const auto same = [&](const NetworkSetup& before, const NetworkSetup& after) {
    return before.type == after.type && differences(before, after, 1).empty() &&
           now.proxy.networks.at(before.id) == next.proxy.networks.at(after.id);
  };
  for (const auto& before : now.networks) {
    const auto* stays = find(next.networks, before.id);
    if (stays && same(before, *stays)) continue;
    for (const auto& after : next.networks) {
      const auto* other = find(now.networks, after.id);
      if (after.id == before.id || !same(before, after) || (other && same(*other, after))) continue;
      plan.lines.push_back(fmt::format("network {}: is called {} now; stored devices and values stay with the old id",
                                       before.id, after.id));
      break;
    }
  }
}

void compare_networks(const IslandConfig& now, const IslandConfig& next, ReloadPlan& plan) {
  for (const auto& setup : now.networks) {
    if (find(next.networks, setup.id)) continue;
    plan.removed.push_back(setup.id);
    plan.lines.push_back(fmt::format("network {}: is removed with its devices", setup.id));
  }
  for (const auto& setup : next.networks) {
    const auto* before = find(now.networks, setup.id);
    if (!before) {
      plan.added.push_back(setup.id);
      plan.lines.push_back(fmt::format("network {}: is added", setup.id));
      continue;
    }
    if (before->type != setup.type) {
      plan.retyped.push_back(setup.id);
      plan.lines.push_back(fmt::format("network {}: is recreated, its type changes", setup.id));
    } else if (const auto paths = differences(*before, setup, kNamed + 1); !paths.empty()) {
      plan.changed.push_back(setup.id);
      plan.lines.push_back(fmt::format("network {}: its options change: {}", setup.id, list(paths)));
    }
    compare_rules(setup.id, now.proxy.networks.at(setup.id), next.proxy.networks.at(setup.id), plan);
  }
}

/// Recorders and bridges.
template <class Setup>
void compare_parts(const char* what, const std::vector<Setup>& now, const std::vector<Setup>& next, ReloadPlan& plan) {
  const auto called = [](const std::string& name) { return [&name](const auto& setup) { return setup.name == name; }; };
  for (const auto& setup : now) {
    if (std::none_of(next.begin(), next.end(), called(setup.name)))
      plan.lines.push_back(fmt::format("{} {}: ends", what, setup.name));
  }
  for (const auto& setup : next) {
    const auto before = std::find_if(now.begin(), now.end(), called(setup.name));
    if (before == now.end()) {
      plan.lines.push_back(fmt::format("{} {}: starts", what, setup.name));
    } else if (!(*before == setup)) {
      plan.lines.push_back(fmt::format("{} {}: is restarted, its options change", what, setup.name));
    }
  }
}

void compare_history(const std::optional<config::HistorySetup>& now, const std::optional<config::HistorySetup>& next,
                     ReloadPlan& plan) {
  if (now == next) return;
  const auto* what = !next ? "ends" : !now ? "begins" : "is opened again, its options change";
  plan.lines.push_back(fmt::format("history: it {}", what));
}

void compare_web(const std::optional<config::WebSetup>& now, const std::optional<config::WebSetup>& next,
                 ReloadPlan& plan) {
  if (now == next) return;
  const auto* what = !next ? "closes" : !now ? "opens" : "is opened again, its options change";
  plan.lines.push_back(fmt::format("web: the page {}", what));
}

void compare_rights(const std::optional<config::RightsSetup>& now, const std::optional<config::RightsSetup>& next,
                    ReloadPlan& plan) {
  if (now == next) return;
  const auto count = next ? next->rules.size() : 0;
  plan.lines.push_back(next ? fmt::format("rights: {} rule{} from now on", count, count == 1 ? "" : "s")
                            : std::string("rights: only members with the role admin have any from now on"));
}

}  // namespace

ReloadPlan plan_reload(const IslandConfig& now, const IslandConfig& next) {
  ReloadPlan plan;
  for (std::size_t i = 0; i < next.fixed.size() && i < now.fixed.size(); ++i) {
    const auto& [section, node] = next.fixed[i];
    refuse_changes(section, now.fixed[i].second, node, plan);
  }
  find_renamed(now, next, plan);
  compare_networks(now, next, plan);
  compare_parts("recorder", now.recorders, next.recorders, plan);
  compare_parts("bridge", now.bridges, next.bridges, plan);
  compare_history(now.history, next.history, plan);
  compare_web(now.web, next.web, plan);
  compare_rights(now.rights, next.rights, plan);
  if (!(now.audit == next.audit)) plan.lines.push_back("audit: its options change");
  if (!(now.limits == next.limits)) plan.lines.push_back("limits change");
  if (!(now.proxy.discovery == next.proxy.discovery)) plan.lines.push_back("discovery rules change");
  const bool commands = now.proxy.command_time_to_live == next.proxy.command_time_to_live &&
                        now.proxy.confirmation_wait == next.proxy.confirmation_wait &&
                        now.proxy.queue_expiry == next.proxy.queue_expiry;
  if (!commands) plan.lines.push_back("command times change");
  return plan;
}

namespace {

std::size_t digest_of(const std::string& path, transport::Transports& transports) {
  auto file = transports.open_file(path);
  if (!file) return 0;
  std::size_t digest = 1;
  base::Bytes piece(65536);
  for (std::size_t total = 0; total < kMaxOptionsFile && digest != 0;) {
    const auto count = (*file)->read(piece);
    if (count && *count == 0) break;
    const auto text = base::as_text(base::ByteView(piece).first(count.value_or(0)));
    digest = count ? 31 * digest + std::hash<std::string_view>()(text) : 0;
    total += text.size();
  }
  ::explicit_bzero(piece.data(), piece.size());  // it may be a password
  return digest;
}

}  // namespace

FileDigests digests_of_options_files(const island::NetworkSetup& setup, const std::string& directory,
                                     transport::Transports& transports) {
  FileDigests digests;
  if (!setup.type) return digests;
  for (const auto name : setup.type->file_options) {
    const auto* option = setup.options.find(name);
    if (!option || option->text.empty()) continue;
    digests[std::string(name)] = digest_of((std::filesystem::path(directory) / option->text).string(), transports);
  }
  return digests;
}

std::vector<std::string> changed_files(const FileDigests& before, const FileDigests& now) {
  std::vector<std::string> changed;
  for (const auto& [name, digest] : now) {
    const auto known = before.find(name);
    if (known == before.end() ? digest == 0 : known->second == digest) continue;
    changed.push_back(name.ends_with("-file") ? name : name + " file");
  }
  return changed;
}

}  // namespace rubicon::island
