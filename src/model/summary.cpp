#include "rubicon/summary.hpp"

#include "model/json_members.h"
#include "model/json_text.h"
#include "rubicon/key.hpp"

namespace rubicon::model {

namespace {

using Tree = nlohmann::ordered_json;

/// Longest text taken of a foreign summary.
constexpr std::size_t kMaxSummaryText = 256;

std::string short_text_of(const Tree& tree, const char* name) {
  return text_of(tree, name).substr(0, kMaxSummaryText);
}

}  // namespace

std::string to_json(const Summary& summary) {
  Tree tree;
  tree["name"] = summary.name.substr(0, kMaxSummaryText);
  tree["host"] = summary.host.substr(0, kMaxSummaryText);
  tree["program"] = summary.program.substr(0, kMaxSummaryText);
  if (!summary.prefix.empty()) tree["prefix"] = summary.prefix;
  tree["since"] = base::to_seconds(summary.since);
  if (summary.networks.empty()) return dump(tree);
  auto whole = tree;
  for (const auto& [id, devices] : summary.networks) whole["networks"][id] = devices;
  auto text = dump(whole);
  return text.size() <= kMaxSummary ? text : dump(tree);
}

Result<Summary> summary_from_json(std::string_view text) {
  const auto tree = parse_json(text);  // faster than ordered_json with many members
  if (!tree.is_object())
    return fail(ErrorCode::kInvalid, "summary of a component: expected a JSON object, got " + model::quoted(text));
  Summary summary;
  summary.name = short_text_of(tree, "name");
  summary.host = short_text_of(tree, "host");
  summary.program = short_text_of(tree, "program");
  summary.prefix = short_text_of(tree, "prefix");
  if (!check_key(summary.prefix)) summary.prefix.clear();
  summary.since = time_of(tree, "since");
  if (const auto networks = tree.find("networks"); networks != tree.end() && networks->is_object()) {
    for (const auto& [id, devices] : networks->items()) {
      if (devices.is_number_unsigned()) summary.networks[id.substr(0, kMaxSummaryText)] = devices.get<std::uint64_t>();
    }
  }
  return summary;
}

}  // namespace rubicon::model
