#include "networks/zigbee/device/reports.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/text.h"
#include "model/json_text.h"
#include "networks/zigbee/device/state_message.h"

namespace rubicon::networks::zigbee::device {

namespace {

using nlohmann::json;

/// Without last_seen, what Zigbee2MQTT publishes so soon after its start may be old.
constexpr Duration kStartTime = std::chrono::seconds(10);
/// A get without an answer is forgotten.
constexpr Duration kAnswerTime = std::chrono::seconds(10);
/// By how much a reported part of a colour may differ from the commanded one: devices round.
constexpr double kShare = 1e-3, kPartTolerance = 2e-3;
/// The same for other numbers, which devices keep in single precision.
constexpr double kNoise = 1e-6;

bool is_known(const Property& property) {
  return !property.text.empty() && property.text != "null";
}

bool is_whole(double number) {
  return number == std::floor(number);
}

bool is_near(double reported, double wanted, double share) {
  return std::abs(reported - wanted) <= std::abs(wanted) * share;
}

/// Some devices write numbers as strings.
std::optional<double> number_of(std::string_view json) {
  if (json.size() >= 2 && json.front() == '"' && json.back() == '"') json = json.substr(1, json.size() - 2);
  return base::parse_number<double>(json);
}

bool is_colour(const exposes::MappedPoint& point) {
  using Form = exposes::MappedPoint::Coding::Form;
  return point.coding.form == Form::kColourXy || point.coding.form == Form::kColourHueSaturation;
}

bool is_same_part(double reported, double wanted, bool colour) {
  if (colour) return std::abs(reported - wanted) <= std::abs(wanted) * kShare + kPartTolerance;
  if (is_whole(reported) && is_whole(wanted)) return reported == wanted;
  return is_near(reported, wanted, kNoise);
}

bool is_same_json(const json& reported, const json& wanted, bool colour) {
  if (reported.is_number() && wanted.is_number())
    return is_same_part(reported.get<double>(), wanted.get<double>(), colour);
  if (!reported.is_object() || !wanted.is_object()) return reported == wanted;
  return std::all_of(wanted.items().begin(), wanted.items().end(), [&](const auto& part) {
    const auto found = reported.find(part.key());
    return found != reported.end() && is_same_json(*found, part.value(), colour);
  });
}

}  // namespace

std::optional<bool> is_same_number(const exposes::MappedPoint& point, std::string_view reported,
                                   std::string_view wanted) {
  using Form = exposes::MappedPoint::Coding::Form;
  const auto& coding = point.coding;
  if (coding.form != Form::kNumber && coding.form != Form::kInteger) return std::nullopt;
  const auto is = number_of(reported), should = number_of(wanted);
  if (!is || !should) return std::nullopt;
  if (is_whole(*is) && is_whole(*should)) return *is == *should;
  return is_near(*is, *should, kNoise) || std::abs(*is - *should) < coding.step / 2;
}

bool is_same_value(const exposes::MappedPoint& point, const Value& reported, const Value& wanted) {
  const auto* is_text = std::get_if<Json>(&reported);
  const auto* should_text = std::get_if<Json>(&wanted);
  if (!is_text || !should_text) return reported == wanted;
  const auto is_tree = model::parse_json(is_text->text);
  const auto should_tree = model::parse_json(should_text->text);
  if (is_tree.is_discarded() || should_tree.is_discarded()) return is_text->text == should_text->text;
  return is_same_json(is_tree, should_tree, is_colour(point));
}

Reports::Reports(Scheduler& scheduler, const base::SharedList<exposes::MappedPoint>& points, Properties& properties,
                 Commands& commands, Verification& verification)
    : scheduler_(scheduler),
      points_(points),
      properties_(properties),
      commands_(commands),
      verification_(verification) {}

Reports::Found Reports::take(std::span<const Member> members, bool retained) {
  Found found;
  auto heard = this->heard(members, retained);
  auto compared = compare(members, heard, found);
  found.heard |= heard.later && (!heard.copy || heard.answers);
  const bool any_own = take_echoes(compared, heard, found);
  alive_ |= found.heard;
  for (const auto& change : compared.changes) apply(change, heard, judge(change, heard, any_own), found);
  if (!heard.copy || heard.presumed) verification_.message(heard);
  note_last_seen(heard);
  if (!alive_) {
    std::move(found.readings.begin(), found.readings.end(), std::back_inserter(found.stored));
    found.readings.clear();
  }
  return found;
}

/// Whether one of the changes is the value of a command of ours.
bool Reports::take_echoes(Compared& compared, const Heard& heard, Found& found) {
  bool any_own = false;
  for (auto& change : compared.changes) {
    change.own = take_echo(*change.property, change.json, heard);
    any_own |= change.own;
  }
  for (const auto& one : compared.same) {
    if (!take_echo(*one.property, one.json, heard))
      unchanged(*one.property, heard, found);
    else if (!traits_.group)
      doubt(*one.property, Verification::Cause::kEcho, heard);
  }
  return any_own;
}

void Reports::note_last_seen(const Heard& heard) {
  if (!heard.last_seen && !heard.copy) seen_ = heard.arrival;
  if (!heard.last_seen || !heard.later) return;
  seen_ = *heard.last_seen;
  newest_ = heard.last_seen;
  newest_age_ = heard.arrival - *heard.last_seen;
}

Heard Reports::heard(std::span<const Member> members, bool retained) {
  Heard heard;
  heard.arrival = scheduler_.wall_now();
  heard.copy = retained;
  for (const auto& member : members) {
    if (member.key == "last_seen") heard.last_seen = read_last_seen(member.json);
  }
  date(heard);
  const bool repeated = heard.aged && !heard.later && scheduler_.now() < copies_until_;
  heard.at_start = !retained && (heard.copy || repeated);
  return heard;
}

/// A wrong clock of Zigbee2MQTT must not make all its messages old, nor silence a device when it is set back.
void Reports::date(Heard& heard) const {
  if (!heard.last_seen) {
    heard.presumed = !heard.copy && scheduler_.now() < copies_until_;
    heard.copy |= heard.presumed;
    return;
  }
  const Duration age = heard.arrival - *heard.last_seen;
  heard.aged = age > kOld;
  heard.later = !newest_ || *heard.last_seen > *newest_;
  if (newest_ && *heard.last_seen < *newest_) {
    heard.later = !heard.aged;
    heard.older = heard.aged;
  }
  const bool as_before = newest_ && age <= newest_age_ + kOld;
  if (heard.later && heard.aged && !as_before) heard.copy = true;
  heard.copy |= heard.older;
}

Reports::Compared Reports::compare(std::span<const Member> members, Heard& heard, Found& found) {
  Compared compared;
  compared.same.reserve(members.size());
  heard.quiet = true;
  for (const auto& member : members) {
    auto* property = properties_.find(member.key);
    if (!property || !property->published) continue;
    if (property->event) {
      heard.quiet = false;
      event(*property, member.json, heard, found);
      continue;
    }
    heard.answers |= heard.presumed && is_asked(*property);
    const bool same = property->text == member.json;
    (same ? compared.same : compared.changes).push_back({property, member.json});
    if (!same && !property->of_the_link()) heard.quiet = false;
  }
  return compared;
}

/// To prove a command, and the answer may still come. The command had its echo, so what Zigbee2MQTT repeats at its
/// start came before.
bool Reports::is_asked(const Property& property) const {
  return verification_.asks(properties_.index_of(property));
}

void Reports::event(const Property& property, std::string_view json, const Heard& heard, Found& found) {
  if (json == "\"\"" || json == "null" || (heard.copy && !heard.presumed)) return;
  found.heard = true;
  const auto time = heard.last_seen && !heard.aged ? std::min(*heard.last_seen, heard.arrival) : heard.arrival;
  readings(property, json, time, found.readings);
}

bool Reports::take_echo(Property& property, std::string_view json, const Heard& heard) {
  if (heard.older) return false;
  const auto* command = commands_.awaiting(properties_.index_of(property));
  if (!command) return false;
  if (json != command->json && !means(json, *command)) return false;
  commands_.echo(*command);
  return true;
}

/// The state of a group after our command: it is assumed already, and this proves no more.
bool Reports::is_commanded(std::size_t property, std::string_view json) const {
  const auto* last = last_command(property);
  return last && means(json, *last);
}

template <class Sent>
bool Reports::means(std::string_view json, const Sent& command) const {
  const auto& point = points_[command.point];
  if (const auto same = is_same_number(point, json, command.json)) return *same;
  const auto value = exposes::decode(point, json);
  return value && is_same_value(point, *value, command.wanted);
}

/// `beside_own`: the message has the value of a command of ours.
Reports::Verdict Reports::judge(const Change& change, const Heard& heard, bool beside_own) const {
  const auto& property = *change.property;
  if (traits_.group) return Verdict::kStored;
  if (heard.older) return Verdict::kNoNews;
  // An echo never brings a later last_seen; what does is a report (recorded from Zigbee2MQTT 2.14.1).
  const bool by_device = heard.last_seen && heard.later && !heard.copy;
  if (change.own) {
    if (!traits_.optimistic || (by_device && !can_ask(property))) return Verdict::kReport;
    return Verdict::kEcho;
  }
  const bool copy = heard.copy && !(heard.presumed && is_asked(property));
  if (copy && !beside_own) return Verdict::kStored;
  const bool suspect = property.settable && traits_.optimistic && (beside_own || (heard.last_seen && !heard.later));
  if (suspect && can_ask(property) && change.json != "null") return Verdict::kUnproven;
  const bool remembered = !is_known(property) && heard.aged && !heard.later;
  return copy || remembered ? Verdict::kStored : Verdict::kReport;
}

void Reports::apply(const Change& change, const Heard& heard, Verdict verdict, Found& found) {
  auto& property = *change.property;
  const auto index = properties_.index_of(property);
  const bool was_known = is_known(property);
  property.text = change.json;
  property.stored = verdict == Verdict::kStored || verdict == Verdict::kNoNews;
  property.due = verdict == Verdict::kReport && !alive_;
  if (verdict == Verdict::kNoNews) return;
  if (verdict == Verdict::kEcho) return doubt(property, Verification::Cause::kEcho, heard);
  if (verdict == Verdict::kUnproven) return doubt(property, Verification::Cause::kForeign, heard);
  property.unproven = false;
  if (heard.later || !heard.last_seen) property.asked = false;
  // What changes long after the device was heard is a timer of Zigbee2MQTT.
  const bool by_timer = heard.aged && !heard.later && verdict == Verdict::kReport;
  property.changed = by_timer || traits_.group ? heard.arrival : time_of(index, heard.last_seen);
  if (change.json == "null" && !was_known) return;
  if (traits_.group && is_commanded(index, change.json)) return;
  readings(property, change.json, property.changed, verdict == Verdict::kStored ? found.stored : found.readings);
  verification_.reported(index, !last_command(index) || is_commanded(index, change.json));
}

void Reports::doubt(Property& property, Verification::Cause cause, const Heard& heard) {
  const auto index = properties_.index_of(property);
  property.unproven = true;
  property.stored = property.due = false;
  const auto* command = cause == Verification::Cause::kEcho ? last_command(index) : nullptr;
  const auto newest = heard.last_seen && heard.later ? heard.last_seen : newest_;
  verification_.start(index, cause, can_ask(property), newest, command ? command->known_before : newest);
}

void Reports::unchanged(Property& property, const Heard& heard, Found& found) {
  if (heard.at_start) {  // reports may be lost since the value was measured
    property.stored = true;
    property.due = false;
  }
  const bool copy = heard.copy && !(heard.presumed && is_asked(property));
  if (copy || !heard.later || property.unproven || !is_known(property)) return;
  if (property.asked && scheduler_.now() > property.asked_at + kAnswerTime) property.asked = false;
  const bool answers = property.asked && heard.quiet;
  // A clock that is behind made it look like a copy.
  const bool no_copy = property.stored && heard.aged && heard.last_seen;
  if (answers)
    property.changed = time_of(properties_.index_of(property), heard.last_seen);
  else if (!property.due && !no_copy)
    return;
  property.asked = property.due = property.stored = false;
  readings(property, property.text, property.changed, found.readings);
}

Reports::Found Reports::proven(std::size_t index, std::optional<WallTime> seen) {
  Found found;
  auto& property = properties_[index];
  if (!std::exchange(property.unproven, false)) return found;
  found.heard = alive_ = true;
  property.changed = time_of(index, seen);
  readings(property, property.text, property.changed, found.readings);
  return found;
}

void Reports::commanded(const Command& command) {
  std::erase_if(commanded_, [&](const Commanded& older) { return older.property == command.property; });
  commanded_.push_back(
      {command.point, command.property, command.value, command.wanted, command.json, command.published, newest_});
  verification_.set_published();
  const auto& property = properties_[command.property];
  if (!command.echoed || !can_ask(property)) return;
  verification_.start(command.property,
                      traits_.optimistic ? Verification::Cause::kNoEchoYet : Verification::Cause::kNoEchoes, true,
                      newest_, newest_);
}

void Reports::line_up(bool repeats) {
  copies_until_ = scheduler_.now() + (repeats ? kStartTime : Duration(0));
  newest_age_ = Duration(0);
  for (auto& property : properties_.all()) {
    property.asked = false;
    if (property.unproven) doubt(property, Verification::Cause::kForeign, {});
  }
}

void Reports::interrupted() {
  alive_ = false;
  for (auto& property : properties_.all())
    property.due = is_known(property) && !property.unproven && !property.stored && !traits_.group;
}

void Reports::points_changed() {
  commanded_.clear();
  for (auto& property : properties_.all()) {
    if (property.unproven) doubt(property, Verification::Cause::kForeign, {});
  }
}

void Reports::readings(const Property& property, std::string_view json, WallTime time,
                       std::vector<model::Reading>& out) {
  const auto first = out.size();
  const auto points = properties_.points_of(property);
  std::string why;
  for (const auto index : points) {
    const auto& point = points_[index];
    if (json == "null") {
      out.push_back({point.capability.point, {}, time, {}});
      continue;
    }
    auto value = exposes::decode(point, json);
    if (!value) {
      why = value.error().text;
      continue;
    }
    if (std::holds_alternative<std::monostate>(*value)) continue;  // a colour in the terms of the other point
    auto shown = as_commanded(index, json, std::move(*value));
    out.push_back({point.capability.point, std::move(shown), time, {}});
  }
  if (out.size() > first || why.empty()) return;  // of points that share a property, one that reads it is enough
  for (const auto index : points) out.push_back({points_[index].capability.point, {}, time, why});
}

Value Reports::as_commanded(std::size_t point, std::string_view json, Value value) {
  const auto found = std::find_if(commanded_.begin(), commanded_.end(),
                                  [&](const Commanded& command) { return command.point == point; });
  if (found == commanded_.end()) return value;
  if (means(json, *found)) return found->value;
  const bool over = !commands_.awaiting(found->property) && !verification_.is_running(found->property);
  if (over) commanded_.erase(found);
  return value;
}

/// A report that followed a command is not older than it, whatever the clock of Zigbee2MQTT shows; and nothing was
/// measured in the future.
WallTime Reports::time_of(std::size_t property, std::optional<WallTime> seen) const {
  if (!seen) return {};
  auto time = *seen;
  if (const auto* command = last_command(property); command && !commands_.awaiting(property)) {
    const bool after = !command->known_before || time > *command->known_before;
    if (after) time = std::max(time, command->published);
  }
  return std::min(time, scheduler_.wall_now());
}

const Reports::Commanded* Reports::last_command(std::size_t property) const {
  const auto found = std::find_if(commanded_.begin(), commanded_.end(),
                                  [&](const Commanded& command) { return command.property == property; });
  return found == commanded_.end() ? nullptr : &*found;
}

}  // namespace rubicon::networks::zigbee::device
