#include "island/network_controls.h"

#include <fmt/format.h>

#include <set>

#include "model/type_catalogue.h"
#include "rubicon/key.hpp"

namespace rubicon::island {

namespace {

constexpr std::string_view kReopen = "reopen";
/// Longer than any network takes to open its line.
constexpr Duration kLongestReopening = std::chrono::seconds(30);

model::PointDescription line_description() {
  model::PointDescription about;
  about.type = "line";
  about.data_type = "enumeration";
  about.words = {{0, std::string(kReopen)}};
  about.access = to_string(model::Access::kWrite);
  about.report = "state";
  return about;
}

}  // namespace

void NetworkControls::refresh() {
  std::set<std::string> there;
  const model::IslandKey island{place_.config.prefix};
  for (const auto& id : networks_.ids()) {
    there.insert(island.network(id).line().text);
    add_line(id);
    for (const auto& control : networks_.find(id)->controls()) {
      there.insert(island.network(id).control(control.name).text);
      add(id, control);
    }
  }
  std::erase_if(all_, [&](const auto& entry) { return !there.contains(entry.first); });
}

void NetworkControls::add_line(const std::string& network) {
  CommandKey::Calls calls;
  calls.check = [](const std::string& text) -> Result<void> {
    if (text == kReopen) return {};
    return fail(ErrorCode::kInvalid, fmt::format("{}, expected {}", model::quoted(text), kReopen));
  };
  calls.begin = [this, network](const std::string&, CommandKey::Ended ended) {
    return networks_.reopen(network, std::move(ended));
  };
  calls.longest = kLongestReopening;
  add(model::IslandKey{place_.config.prefix}.network(network).line(), line_description(), std::move(calls));
}

void NetworkControls::add(const std::string& network, const network::Control& control) {
  CommandKey::Calls calls;
  calls.check = [](const std::string&) { return Result<void>(); };
  calls.run = [this, network, name = control.name](const std::string& text) {
    return networks_.control(network, name, text);
  };
  add(model::IslandKey{place_.config.prefix}.network(network).control(control.name), control.description,
      std::move(calls));
}

void NetworkControls::add(const model::PointKey& key, const model::PointDescription& description,
                          CommandKey::Calls calls) {
  auto& command = all_[key.text];
  if (command) return;
  command = std::make_unique<CommandKey>(place_, key, std::move(calls));
  command->describe(description);
  command->show();
}

}  // namespace rubicon::island
