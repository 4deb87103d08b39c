#include "rubicon/summary.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "rubicon/key.hpp"
#include "rubicon/tuple.hpp"

namespace rubicon::model {

namespace {

using Tree = nlohmann::ordered_json;

/// Longest text taken of a foreign summary.
constexpr std::size_t kMaxText = 256;
constexpr double kMicros = 1e6;

std::string dump(const Tree& tree) {
  return tree.dump(-1, ' ', false, Tree::error_handler_t::replace);
}

std::string text_of(const Tree& tree, const char* name) {
  const auto found = tree.find(name);
  if (found == tree.end() || !found->is_string()) return {};
  return found->get<std::string>().substr(0, kMaxText);
}

WallTime time_of(const Tree& tree, const char* name) {
  const auto found = tree.find(name);
  if (found == tree.end() || !found->is_number()) return {};
  const auto seconds = found->get<double>();
  constexpr double kLatest = 1e11;  // beyond the year 5000
  if (!(seconds > 0 && seconds < kLatest)) return {};
  return WallTime(std::chrono::microseconds(std::llround(seconds * kMicros)));
}

}  // namespace

std::string to_json(const Summary& summary) {
  Tree tree;
  tree["name"] = summary.name.substr(0, kMaxText);
  tree["host"] = summary.host.substr(0, kMaxText);
  tree["program"] = summary.program.substr(0, kMaxText);
  if (!summary.prefix.empty()) tree["prefix"] = summary.prefix;
  tree["since"] = base::to_seconds(summary.since);
  if (summary.networks.empty()) return dump(tree);
  auto whole = tree;
  for (const auto& [id, devices] : summary.networks) whole["networks"][id] = devices;
  auto text = dump(whole);
  return text.size() <= tuples::kMaxSummary ? text : dump(tree);
}

Result<Summary> summary_from_json(std::string_view text) {
  const auto tree = Tree::parse(text, nullptr, false);
  if (!tree.is_object())
    return fail(ErrorCode::kInvalid, "summary of a component: expected a JSON object, got " + quoted(text));
  Summary summary;
  summary.name = text_of(tree, "name");
  summary.host = text_of(tree, "host");
  summary.program = text_of(tree, "program");
  summary.prefix = text_of(tree, "prefix");
  if (!check_key(summary.prefix)) summary.prefix.clear();
  summary.since = time_of(tree, "since");
  if (const auto networks = tree.find("networks"); networks != tree.end() && networks->is_object()) {
    for (const auto& [id, devices] : networks->items()) {
      if (devices.is_number_unsigned()) summary.networks[id.substr(0, kMaxText)] = devices.get<std::uint64_t>();
    }
  }
  return summary;
}

}  // namespace rubicon::model
