#include "model/point_tuples.h"

#include "model/json_members.h"

namespace rubicon::model {

namespace {

using Tree = nlohmann::ordered_json;

Tree parsed(std::string_view text) {
  auto tree = Tree::parse(text, nullptr, false);
  return tree.is_object() ? tree : Tree::object();
}

std::uint64_t count_of(const Tree& tree, const char* name) {
  const auto found = tree.find(name);
  return found != tree.end() && found->is_number_unsigned() ? found->get<std::uint64_t>() : 0;
}

/// A whole number of seconds without a fraction.
Tree seconds_of(WallTime time) {
  const auto micros = time.time_since_epoch().count();
  return micros % 1000000 == 0 ? Tree(micros / 1000000) : Tree(base::to_seconds(time));
}

}  // namespace

PointStatus point_status_from_json(std::string_view text) {
  const auto tree = parsed(text);
  PointStatus status{text_of(tree, "quality"), text_of(tree, "reason"),  time_of(tree, "since"),
                     time_of(tree, "heard"),   time_of(tree, "changed"), {}};
  if (const auto command = tree.find("command"); command != tree.end() && command->is_object())
    status.command = text_of(*command, "state");
  return status;
}

DeviceCondition device_condition_from_json(std::string_view text) {
  const auto tree = parsed(text);
  return {text_of(tree, "status"), text_of(tree, "reason"), time_of(tree, "since")};
}

std::string device_condition_to_json(const DeviceCondition& condition) {
  return dump({{"status", condition.status}, {"since", seconds_of(condition.since)}, {"reason", condition.reason}});
}

LineStatus line_status_from_json(std::string_view text) {
  const auto tree = parsed(text);
  return {text_of(tree, "line"), text_of(tree, "reason"), time_of(tree, "since"), count_of(tree, "attempts"),
          time_of(tree, "next_attempt")};
}

std::string line_status_to_json(const LineStatus& status) {
  return dump({{"line", status.line},
               {"since", seconds_of(status.since)},
               {"reason", status.reason},
               {"attempts", status.attempts},
               {"next_attempt", seconds_of(status.next_attempt)}});
}

}  // namespace rubicon::model
