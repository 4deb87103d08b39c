#include "bridges/mqtt/discovery.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>

#include "model/home_assistant.h"

namespace rubicon::bridges::mqtt {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMaxOptions = 256;
/// Bounds of a number that has none.
constexpr double kAnyNumber = 1e9;

std::string off_word(const PointEntry& point) {
  return point.about->words.empty() ? "off" : point.about->words.front().text;
}

void add_unit(const PointEntry& point, const model::EntityClass* known, Json& body) {
  auto unit = known && !known->unit.empty() ? std::string(known->unit) : model::to_entity_unit(point.about->unit);
  if (unit == "-") unit.clear();
  if (!unit.empty()) body["unit_of_meas"] = unit;
  if (known && !known->device_class.empty()) body["dev_cla"] = known->device_class;
}

void add_category(const PointEntry& point, bool diagnostic, bool writes, Json& body) {
  if (point.kind == model::Kind::kProperty)
    body["ent_cat"] = writes ? "config" : "diagnostic";
  else if (diagnostic && !writes)
    body["ent_cat"] = "diagnostic";
}

std::string number_text(double number) {
  return fmt::format("{:g}", number);
}

bool is_number(const PointEntry& point) {
  return point.about->data_type == "real" || point.about->data_type == "integer";
}

Entity shown_number(const PointEntry& point) {
  Entity made{"sensor", {}, {{"stat_t", point.topic()}}};
  const auto* known = model::entity_class_of(point.type());
  add_unit(point, known, made.body);
  made.body["stat_cla"] = known ? known->state_class : "measurement";
  if (known && known->factor != 1)
    made.body["val_tpl"] = fmt::format("{{{{ value | float * {} }}}}", number_text(known->factor));
  add_category(point, known && known->diagnostic, false, made.body);
  return made;
}

Entity shown_boolean(const PointEntry& point) {
  Entity made{"binary_sensor", {}, {{"stat_t", point.topic()}}};
  const auto* known = model::binary_class_of(point.type());
  const bool reversed = known && known->first_is_on;
  made.body["pl_on"] = reversed ? off_word(point) : on_word(point);
  made.body["pl_off"] = reversed ? on_word(point) : off_word(point);
  if (known && !known->device_class.empty()) made.body["dev_cla"] = known->device_class;
  add_category(point, known && known->diagnostic, false, made.body);
  return made;
}

void add_template(Json& body, const char* key, std::string_view text) {
  if (!text.empty()) body[key] = text;
}

/// Words that a device reports beside its own would be refused there: only lists that are known are enumerations.
Entity shown_text(const PointEntry& point) {
  Entity made{"sensor", {}, {{"stat_t", point.topic()}}};
  const bool words = point.about->data_type == "enumeration" && !point.about->words.empty();
  const auto* known = model::text_class_of(point.type());
  if (words) {
    made.body["dev_cla"] = "enum";
    made.body["ops"] = words_of(point);
  } else if (known) {
    add_template(made.body, "dev_cla", known->device_class);
    add_template(made.body, "val_tpl", known->value_template);
  } else {
    made.body["val_tpl"] = "{{ value[:255] }}";
  }
  add_category(point, point.type() == "status", false, made.body);
  return made;
}

/// The payload is the word; the template makes of it what the receiver expects.
Entity shown_event(const PointEntry& point) {
  Entity made{"event", {}, {{"stat_t", point.topic()}}};
  const auto words = words_of(point);
  if (words.empty()) {
    const auto type = point.about->data_type == "boolean" ? std::string("on") : std::string(point.type());
    made.body["event_types"] = {type};
    made.body["val_tpl"] = fmt::format(R"({{"event_type":"{}","value":{{{{ value | tojson }}}}}})", type);
  } else {
    made.body["event_types"] = words;
    made.body["val_tpl"] = R"({"event_type":{{ value | tojson }}})";
  }
  if (point.type() == "button" || point.type() == "action" || point.type() == "buttonCount")
    made.body["dev_cla"] = "button";
  if (point.type() == "doorbell") made.body["dev_cla"] = "doorbell";
  return made;
}

Entity shown(const PointEntry& point) {
  if (point.is_event()) return shown_event(point);
  if (is_number(point)) return shown_number(point);
  if (point.about->data_type == "boolean") return shown_boolean(point);
  return shown_text(point);
}

Entity set_number(const PointEntry& point) {
  Entity made{"number", {}, commanded(point)};
  const auto& about = *point.about;
  const auto* known = model::entity_class_of(point.type());
  const double factor = known ? known->factor : 1;
  const bool bounded = about.minimum && about.maximum && std::isfinite(*about.minimum) && std::isfinite(*about.maximum);
  made.body["min"] = bounded ? *about.minimum * factor : -kAnyNumber;
  made.body["max"] = bounded ? *about.maximum * factor : kAnyNumber;
  made.body["step"] = about.data_type == "integer" ? 1.0 : 0.1;
  made.body["mode"] = bounded && about.unit == "%" ? "slider" : "box";
  add_unit(point, known, made.body);
  if (factor != 1) {
    made.body["val_tpl"] = fmt::format("{{{{ value | float * {} }}}}", number_text(factor));
    made.body["cmd_tpl"] = fmt::format("{{{{ value / {} }}}}", number_text(factor));
  }
  return made;
}

/// Points that are written and have no state: each write is one press.
Entity set_event(const PointEntry& point) {
  if (point.about->data_type == "boolean")
    return {"button", {}, {{"cmd_t", point.topic("/set")}, {"pl_prs", on_word(point)}}};
  auto body = commanded(point);
  const auto words = words_of(point);
  if (words.size() == 1) {
    Json press{{"cmd_t", point.topic("/set")}, {"pl_prs", words.front()}};
    if (point.type() == "identify") press["dev_cla"] = "identify";
    return {"button", {}, std::move(press)};
  }
  if (!words.empty()) {
    body["ops"] = words;
    return {"select", {}, std::move(body)};
  }
  body.erase("opt");
  if (!is_number(point)) return {"text", {}, std::move(body)};
  body["opt"] = false;
  body["min"] = point.about->minimum.value_or(-kAnyNumber);
  body["max"] = point.about->maximum.value_or(kAnyNumber);
  body["mode"] = "box";
  return {"number", {}, std::move(body)};
}

Entity set_boolean(const PointEntry& point) {
  Entity made{"switch", {}, commanded(point)};
  for (const char* on : {"pl_on", "stat_on"}) made.body[on] = on_word(point);
  for (const char* off : {"pl_off", "stat_off"}) made.body[off] = off_word(point);
  return made;
}

Entity set(const PointEntry& point) {
  if (point.is_event()) return set_event(point);
  if (is_number(point)) return set_number(point);
  if (point.about->data_type == "boolean") return set_boolean(point);
  if (const auto* known = model::text_class_of(point.type())) {
    Entity made{std::string(known->platform), {}, commanded(point)};
    add_template(made.body, "val_tpl", known->value_template);
    add_template(made.body, "cmd_tpl", known->command_template);
    return made;
  }
  const auto words = words_of(point);
  Entity made{words.empty() ? "text" : "select", {}, commanded(point)};
  if (!words.empty()) made.body["ops"] = words;
  if (words.empty()) made.body.erase("opt");
  return made;
}

}  // namespace

std::vector<std::string> words_of(const PointEntry& point) {
  std::vector<std::string> words;
  for (const auto& word : point.about->words) {
    if (words.size() < kMaxOptions) words.push_back(word.text);
  }
  return words;
}

std::string on_word(const PointEntry& point) {
  return point.about->words.size() < 2 ? "on" : point.about->words[1].text;
}

nlohmann::ordered_json commanded(const PointEntry& point) {
  return {{"stat_t", point.topic()}, {"cmd_t", point.topic("/set")}, {"opt", false}};
}

std::string words_of_id(std::string_view id) {
  std::string text;
  for (const char c : id) {
    const bool capital = std::isupper(static_cast<unsigned char>(c)) != 0;
    if (capital && !text.empty() && text.back() != ' ') text += ' ';
    const auto plain = c == '-' || c == '_' ? ' ' : c;
    text += static_cast<char>(text.empty() ? std::toupper(plain) : std::tolower(plain));
  }
  return text;
}

std::vector<Entity> entities_of(const DeviceEntry& device, const std::function<bool(const PointEntry&)>& takes) {
  std::vector<const PointEntry*> written, left;
  std::map<std::string_view, std::size_t> count;
  for (const auto* point : device.points) {
    if (!point->about || point->about->data_type == "bytes") continue;
    ++count[point->type()];
    const bool can = point->kind != model::Kind::kSensor && point->can_write() && takes(*point);
    (can ? written : left).push_back(point);
  }
  auto all = composites_of(written, left);
  const auto add = [&](Entity made, const PointEntry& point, bool writes) {
    made.id = entity_id(point);
    const auto only = count[point.type()] == 1 && point.instance() == "1";
    made.body["name"] = words_of_id(only ? point.id().substr(0, point.id().find('-')) : point.id());
    if (writes) add_category(point, false, true, made.body);
    all.push_back(std::move(made));
  };
  for (const auto* point : written) add(set(*point), *point, true);
  for (const auto* point : left) {
    if (point->about->access != "write") add(shown(*point), *point, false);
  }
  return all;
}

std::string entity_id(const PointEntry& point) {
  return fmt::format("{}-{}", to_string(point.kind), point.id());
}

}  // namespace rubicon::bridges::mqtt
