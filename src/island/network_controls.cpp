#include "island/network_controls.h"

#include <set>

namespace rubicon::island {

void NetworkControls::refresh() {
  std::set<std::string> there;
  const model::IslandKey island{place_.config.prefix};
  for (const auto& id : networks_.ids()) {
    for (const auto& control : networks_.find(id)->controls()) {
      there.insert(island.network(id).control(control.name).text);
      add(id, control);
    }
  }
  std::erase_if(all_, [&](const auto& entry) { return !there.contains(entry.first); });
}

void NetworkControls::add(const std::string& network, const network::Control& control) {
  const auto key = model::IslandKey{place_.config.prefix}.network(network).control(control.name);
  auto& command = all_[key.text];
  if (command) return;
  CommandKey::Calls calls;
  calls.check = [](const std::string&) { return Result<void>(); };
  calls.run = [this, network, name = control.name](const std::string& text) {
    return networks_.control(network, name, text);
  };
  command = std::make_unique<CommandKey>(place_, key, std::move(calls));
  command->describe(control.description);
  command->show();
}

}  // namespace rubicon::island
