#include "model/alerts.h"

#include "model/json_members.h"
#include "model/json_text.h"

namespace rubicon::model {

namespace {

constexpr std::size_t kMaxAlertBytes = 500;

/// Broken UTF-8 at the end is replaced when the JSON is written.
std::string shortened(const std::string& text) {
  return text.size() <= kMaxAlertBytes ? text : text.substr(0, kMaxAlertBytes);
}

}  // namespace

std::string_view to_string(Severity severity) {
  return severity == Severity::kProblem ? "problem" : "warning";
}

std::string alerts_to_json(const AlertList& list) {
  auto alerts = nlohmann::ordered_json::array();
  for (const auto& one : list.all) {
    alerts.push_back({{"kind", one.kind},
                      {"about", one.about},
                      {"severity", to_string(one.severity)},
                      {"since", seconds_json(one.since)},
                      {"what", shortened(one.what)},
                      {"fix", shortened(one.fix)}});
  }
  return dump(nlohmann::ordered_json{{"alerts", std::move(alerts)}, {"more", list.more}});
}

AlertList alerts_from_json(std::string_view text) {
  const auto tree = object_of(text);
  AlertList list;
  list.more = count_of(tree, "more");
  const auto alerts = tree.find("alerts");
  if (alerts == tree.end() || !alerts->is_array()) return list;
  for (const auto& one : *alerts) {
    if (!one.is_object()) continue;
    list.add([&one] {
      const bool problem = text_of(one, "severity") == to_string(Severity::kProblem);
      return Alert{text_of(one, "kind"),  text_of(one, "about"), problem ? Severity::kProblem : Severity::kWarning,
                   time_of(one, "since"), text_of(one, "what"),  text_of(one, "fix")};
    });
  }
  return list;
}

}  // namespace rubicon::model
