#include "model/point_tuples.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "base/text.h"
#include "model/json_members.h"
#include "model/json_text.h"

namespace rubicon::model {

std::string_view to_string(Quality quality) {
  switch (quality) {
    case Quality::kNetworkDown: return "network-down";
    case Quality::kDeviceOffline: return "device-offline";
    case Quality::kBad: return "bad";
    case Quality::kUnknown: return "unknown";
    case Quality::kStale: return "stale";
    case Quality::kStored: return "stored";
    case Quality::kAssumed: return "assumed";
    case Quality::kGood: return "good";
  }
  return "unknown";
}

std::optional<Quality> parse_quality(std::string_view word) {
  for (auto quality = Quality::kNetworkDown; quality <= Quality::kGood;
       quality = static_cast<Quality>(static_cast<std::uint8_t>(quality) + 1)) {
    if (to_string(quality) == word) return quality;
  }
  return std::nullopt;
}

namespace {

/// Of a status, in bytes: the first members stand there.
constexpr std::size_t kFirstMembers = 200;

using Tree = nlohmann::ordered_json;
/// For texts of others: ordered_json searches all members for each one that it adds, which takes seconds for many.
using ParsedTree = nlohmann::json;

void put_commander(Tree& tree, const Commander& commander) {
  tree["creator"] = number(commander.creator);
  tree["commander"] = commander.name;
  tree["request"] = commander.request;
}

Commander commander_in(const ParsedTree& tree) {
  const auto creator = count_of(tree, "creator");
  const bool fits = creator <= std::numeric_limits<std::uint32_t>::max();
  return {OwnerId(fits ? static_cast<std::uint32_t>(creator) : 0), text_of(tree, "commander"),
          count_of(tree, "request")};
}

void put_words(Tree& tree, const std::vector<Word>& words) {
  Tree texts = Tree::array(), codes = Tree::array();
  bool counted = true;
  for (const auto& word : words) {
    counted = counted && word.value == codes.size();
    texts.push_back(word.text);
    codes.push_back(word.value);
  }
  tree["words"] = std::move(texts);
  if (!counted) tree["codes"] = std::move(codes);
}

std::vector<Word> words_in(const ParsedTree& tree) {
  std::vector<Word> words;
  const auto codes = tree.find("codes");
  for (auto& text : texts_of(tree, "words")) {
    if (text.empty()) continue;
    const auto place = words.size();
    const bool coded = codes != tree.end() && codes->is_array() && place < codes->size();
    if (coded && !(*codes)[place].is_number_unsigned()) return {};
    const auto value = coded ? std::min<std::uint64_t>((*codes)[place].get<std::uint64_t>(), UINT16_MAX) : place;
    words.push_back({static_cast<std::uint32_t>(value), std::move(text)});
  }
  return words;
}

std::optional<double> bound_in(const ParsedTree& tree, const char* name) {
  const auto found = tree.find(name);
  return found != tree.end() && found->is_number() ? std::optional(found->get<double>()) : std::nullopt;
}

std::string_view text_after(std::string_view text, std::string_view mark) {
  const auto at = text.find(mark);
  return at == text.npos ? std::string_view() : text.substr(at + mark.size());
}

}  // namespace

std::string command_status_to_json(const CommandStatus& command) {
  Tree tree;
  tree["state"] = command.state;
  put_commander(tree, command.commander);
  tree["value"] = command.value;
  tree["since"] = seconds_json(command.since);
  if (command.until != WallTime{}) tree["until"] = seconds_json(command.until);
  tree["reason"] = command.reason;
  if (command.by) put_commander(tree["by"], *command.by);
  return dump(tree);
}

std::optional<CommandStatus> command_status_from_json(std::string_view point_status) {
  const auto status = object_of(point_status);
  const auto found = status.find("command");
  if (found == status.end() || !found->is_object()) return std::nullopt;
  CommandStatus command{text_of(*found, "state"),
                        commander_in(*found),
                        text_of(*found, "value"),
                        time_of(*found, "since"),
                        time_of(*found, "until"),
                        text_of(*found, "reason"),
                        {}};
  if (const auto by = found->find("by"); by != found->end() && by->is_object()) command.by = commander_in(*by);
  return command;
}

std::string command_outcomes_to_json(std::span<const CommandOutcome> outcomes) {
  Tree list = Tree::array();
  for (const auto& one : outcomes) {
    list.push_back({{"creator", number(one.creator)}, {"request", one.request}, {"state", one.state}});
    if (!one.reason.empty()) list.back()["reason"] = one.reason;
  }
  return dump(list);
}

std::optional<CommandOutcome> command_outcome_from_json(std::string_view point_status, OwnerId creator,
                                                        std::uint64_t request) {
  if (point_status.find("\"ended\":[") == point_status.npos) return std::nullopt;
  const auto status = object_of(point_status);
  const auto found = status.find("ended");
  if (found == status.end() || !found->is_array()) return std::nullopt;
  for (const auto& one : *found) {
    if (!one.is_object() || count_of(one, "creator") != number(creator) || count_of(one, "request") != request)
      continue;
    return CommandOutcome{creator, request, text_of(one, "state"), text_of(one, "reason")};
  }
  return std::nullopt;
}

void write_point_status(const PointStatusPieces& status, std::string& out) {
  out = "{\"quality\":\"";
  out += status.quality;
  out += "\",\"since\":";
  append_seconds(status.since, out);
  out += ",\"heard\":";
  append_seconds(status.heard, out);
  out += ",\"changed\":";
  append_seconds(status.changed, out);
  out += ",\"reason\":";
  append_json(status.reason, out);
  if (!status.command.empty()) {
    out += ",\"command\":";
    out += status.command;
  }
  if (!status.ended.empty()) {
    out += ",\"ended\":";
    out += status.ended;
  }
  out += '}';
}

PointStatus point_status_from_json(std::string_view text) {
  const auto tree = object_of(text);
  PointStatus status{text_of(tree, "quality"), text_of(tree, "reason"),  time_of(tree, "since"),
                     time_of(tree, "heard"),   time_of(tree, "changed"), {}};
  if (const auto command = tree.find("command"); command != tree.end()) status.command = text_of(*command, "state");
  return status;
}

std::optional<Quality> quality_from_json(std::string_view text) {
  const auto word = text_after(text.substr(0, kFirstMembers), R"("quality":")");
  return parse_quality(word.substr(0, word.find('"')));
}

std::optional<HeardQuality> heard_quality_from_json(std::string_view text) {
  text = text.substr(0, kFirstMembers);
  const auto quality = quality_from_json(text);
  if (!quality) return std::nullopt;
  const auto heard = text_after(text, R"("heard":)");
  const auto seconds = base::parse_number<double>(heard.substr(0, heard.find_first_of(",}")));
  return HeardQuality{*quality, time_from_seconds(seconds.value_or(0))};
}

std::string point_description_to_json(const PointDescription& description) {
  Tree tree;
  tree["type"] = description.type;
  tree["type_id"] = description.type_id;
  tree["quantity"] = description.quantity;
  tree["unit"] = description.unit;
  tree["data_type"] = description.data_type;
  if (description.minimum) tree["minimum"] = *description.minimum;
  if (description.maximum) tree["maximum"] = *description.maximum;
  if (!description.words.empty()) put_words(tree, description.words);
  tree["access"] = description.access;
  tree["report"] = description.report;
  tree["instance"] = description.instance;
  return dump(tree);
}

std::optional<PointDescription> point_description_from_json(std::string_view text) {
  const auto tree = parse_json(text);
  if (!tree.is_object()) return std::nullopt;
  return PointDescription{
      text_of(tree, "type"),      count_of(tree, "type_id"), text_of(tree, "quantity"), text_of(tree, "unit"),
      text_of(tree, "data_type"), bound_in(tree, "minimum"), bound_in(tree, "maximum"), words_in(tree),
      text_of(tree, "access"),    text_of(tree, "report"),   text_of(tree, "instance")};
}

std::string device_condition_to_json(const DeviceCondition& condition) {
  return dump(
      Tree{{"status", condition.status}, {"since", seconds_json(condition.since)}, {"reason", condition.reason}});
}

DeviceCondition device_condition_from_json(std::string_view text) {
  const auto tree = object_of(text);
  return {text_of(tree, "status"), text_of(tree, "reason"), time_of(tree, "since")};
}

bool says_reachable(std::string_view device_status) {
  return device_status.find(R"("status":"reachable")") != device_status.npos;
}

std::string device_description_to_json(const DeviceDescription& description) {
  Tree tree;
  tree["name"] = description.name;
  if (!description.area.empty()) tree["area"] = description.area;
  tree["model"] = description.model;
  tree["type"] = description.type;
  tree["address"] = description.address;
  tree["network"] = description.network;
  tree["capabilities"] = description.capabilities;
  tree["sensors"] = description.sensors;
  tree["actuators"] = description.actuators;
  tree["properties"] = description.properties;
  return dump(tree);
}

std::optional<DeviceDescription> device_description_from_json(std::string_view text) {
  const auto tree = parse_json(text);
  if (!tree.is_object()) return std::nullopt;
  return DeviceDescription{text_of(tree, "name"),          text_of(tree, "area"),     text_of(tree, "model"),
                           text_of(tree, "type"),          text_of(tree, "address"),  text_of(tree, "network"),
                           texts_of(tree, "capabilities"), texts_of(tree, "sensors"), texts_of(tree, "actuators"),
                           texts_of(tree, "properties")};
}

std::string line_status_to_json(const LineStatus& status) {
  Tree tree{{"line", status.line},
            {"since", seconds_json(status.since)},
            {"reason", status.reason},
            {"attempts", status.attempts},
            {"next_attempt", seconds_json(status.next_attempt)}};
  if (!status.finding.empty()) tree["finding"] = status.finding;
  return dump(tree);
}

LineStatus line_status_from_json(std::string_view text) {
  const auto tree = object_of(text);
  return {text_of(tree, "line"),      text_of(tree, "reason"),       time_of(tree, "since"),
          count_of(tree, "attempts"), time_of(tree, "next_attempt"), text_of(tree, "finding")};
}

}  // namespace rubicon::model
