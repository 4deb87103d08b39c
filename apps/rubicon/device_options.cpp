#include "apps/rubicon/device_options.h"

#include <fmt/format.h>

#include "apps/rubicon/session.h"
#include "apps/rubicon/suggestions.h"
#include "apps/rubicon/tuple_text.h"
#include "base/text.h"

namespace rubicon::cli {

namespace {

/// `6541:` in front of the rest, which stays in `word`.
std::optional<OwnerId> take_island(std::string_view& word) {
  const auto colon = word.find(':');
  const auto id = base::parse_number<std::uint32_t>(word.substr(0, colon));
  if (colon == word.npos || !id) return std::nullopt;
  word.remove_prefix(colon + 1);
  return OwnerId(*id);
}

}  // namespace

void DeviceOptions::add_to(CLI::App& app) {
  island_.add_to(&app, "of this island only: id or name");
  app.add_option("--network", network_, "of this network; * and ? as in a shell; ISLAND: in front");
  app.add_option("--type", type_, "of this type, or with a sensor, actuator or property of it");
  app.add_option("--name", name_, "with this name, key part or address");
  app.add_option("--area", area_, "in this room or place");
}

int DeviceOptions::run(Session& session, const std::function<int(const client::DeviceQuery&)>& command) {
  return with_network(session, island_, network_, [&] {
    return command({island_.owner(), network_, type_, name_, area_});
  });
}

std::vector<client::Device> devices_called(const std::vector<client::Device>& all, std::string_view word) {
  const auto island = take_island(word);
  std::vector<client::Device> by_key, by_name;
  for (const auto& device : all) {
    if (island && device.island != *island) continue;
    if (word == device.id || word == device.network + "." + device.id || word == device.key()) by_key.push_back(device);
    if (word == device.name || word == device.address) by_name.push_back(device);
  }
  return by_key.empty() ? by_name : by_key;
}

int ambiguous(std::string_view word, const std::vector<client::Device>& candidates) {
  std::string names;
  for (const auto& one : candidates) names += "\n  " + name_of(one.island, one.key());
  print_error(fmt::format("{} is ambiguous; name one of these devices:{}", model::quoted(word), names));
  return kUsage;
}

int one_device(Session& session, std::string_view typed, client::Device& device) {
  session.discover();
  const auto word = with_island_id(session, typed);
  const auto all = session.client().devices({}, session.settings().patience);
  auto found = devices_called(all, word);
  if (found.empty())
    return session.not_found(fmt::format("no device {}", model::quoted(word)), suggest_device(all, word));
  if (found.size() > 1) return ambiguous(word, found);
  device = std::move(found[0]);
  return kGood;
}

}  // namespace rubicon::cli
