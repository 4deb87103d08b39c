#include "bridges/mqtt/discovery.h"

#include <fmt/format.h>

#include <algorithm>
#include <initializer_list>
#include <optional>

#include "model/home_assistant.h"

namespace rubicon::bridges::mqtt {

namespace {

using Json = nlohmann::ordered_json;
using Types = std::initializer_list<std::string_view>;

/// Takes the points of a device apart.
class Parts {
 public:
  Parts(Points& written, Points& left) : written_(written), left_(left) {}

  /// The next point of that type, taken; nullptr: there is none.
  const PointEntry* next(std::string_view type) {
    const auto found = std::find_if(written_.begin(), written_.end(), [&](const auto* p) { return p->type() == type; });
    return found == written_.end() ? nullptr : taken(found);
  }
  /// What belongs to it: of one of the types and the same instance, or the only one of its type beside an only one.
  const PointEntry* partner(const PointEntry& of, Types types) {
    for (const auto type : types) {
      if (const auto found = beside(of, type); found != written_.end()) return taken(found);
    }
    return nullptr;
  }
  /// The point of this role of an entity, by the table; it stays an entity of its own too.
  const PointEntry* part(const PointEntry& of, std::string_view platform, std::string_view role) {
    for (const auto& row : model::entity_parts()) {
      if (row.platform != platform || row.role != role) continue;
      if (const auto found = beside(of, row.type); found != written_.end()) return *found;
    }
    return nullptr;
  }
  /// It is no entity of its own.
  void take(const PointEntry& point) { std::erase(written_, &point); }
  /// A sensor that belongs to it; it stays an entity of its own too.
  const PointEntry* sensor(const PointEntry& of, std::string_view type) const {
    auto found = match(left_, of, type, true);
    if (found == left_.end() && alone(left_, type)) found = match(left_, of, type, false);
    return found == left_.end() ? nullptr : *found;
  }

  std::vector<Entity> made;
  void add(std::string platform, const PointEntry& main, Json body) {
    made.push_back({std::move(platform), entity_id(main), std::move(body)});
    mains_.push_back(&main);
  }
  /// The only one of its kind has the name of the device.
  void name_all() {
    for (std::size_t i = 0; i < made.size(); ++i) {
      const auto same = std::count_if(made.begin(), made.end(),
                                      [&](const Entity& other) { return other.platform == made[i].platform; });
      made[i].body["name"] = same == 1 ? Json() : Json(words_of_id(mains_[i]->id()));
    }
  }

 private:
  Points::iterator beside(const PointEntry& of, std::string_view type) {
    const auto found = match(written_, of, type, true);
    const bool only = found == written_.end() && alone(written_, type) && !any(written_, of.type());
    return only ? match(written_, of, type, false) : found;
  }
  const PointEntry* taken(Points::iterator at) {
    const auto* point = *at;
    written_.erase(at);
    return point;
  }
  static Points::iterator match(Points& points, const PointEntry& of, std::string_view type, bool same_instance) {
    return std::find_if(points.begin(), points.end(), [&](const auto* point) {
      return point->type() == type && (!same_instance || point->instance() == of.instance());
    });
  }
  static std::ptrdiff_t count(const Points& points, std::string_view type) {
    return std::count_if(points.begin(), points.end(), [type](const auto* point) { return point->type() == type; });
  }
  static bool alone(const Points& points, std::string_view type) { return count(points, type) == 1; }
  static bool any(const Points& points, std::string_view type) { return count(points, type) > 0; }

  Points& written_;
  Points& left_;
  Points mains_;
};

std::string set_topic(const PointEntry& point) {
  return point.topic("/set");
}

bool has_word(const PointEntry& point, std::string_view word) {
  const auto& words = point.about->words;
  return std::any_of(words.begin(), words.end(), [word](const auto& one) { return one.text == word; });
}

void add_brightness(const PointEntry& dimmer, Json& body) {
  body["bri_cmd_t"] = set_topic(dimmer);
  body["bri_stat_t"] = dimmer.topic();
  body["bri_scl"] = dimmer.type() == "lightLevel" ? 255 : 100;
}

void add_white(Parts& parts, const PointEntry& main, Json& body) {
  const auto* white = parts.partner(main, {"colourTemperature", "colourTemperatureMired"});
  if (white == nullptr) return;
  body["clr_temp_cmd_t"] = set_topic(*white);
  body["clr_temp_stat_t"] = white->topic();
  const bool kelvin = white->type() == "colourTemperature";
  if (kelvin) body["color_temp_kelvin"] = true;
  const auto& about = *white->about;
  if (about.minimum) body[kelvin ? "min_kelvin" : "min_mireds"] = static_cast<int>(*about.minimum);
  if (about.maximum) body[kelvin ? "max_kelvin" : "max_mireds"] = static_cast<int>(*about.maximum);
}

/// `{"x":0.3,"y":0.4}`, `{"hue":30,"saturation":80}` and `#ff8000`, as the catalogue writes them.
void add_colour(Parts& parts, const PointEntry& main, Json& body) {
  const auto add = [&](const PointEntry& point, const std::string& name, const char* command, const char* value) {
    body[name + "_cmd_t"] = set_topic(point);
    body[name + "_stat_t"] = point.topic();
    body[name + "_command_template"] = command;
    body[name + "_val_tpl"] = value;
  };
  if (const auto* xy = parts.partner(main, {"colourXy"}))
    add(*xy, "xy", R"({"x":{{ x }},"y":{{ y }}})", "{{ value_json.x }},{{ value_json.y }}");
  if (const auto* hs = parts.partner(main, {"colourHueSaturation"}))
    add(*hs, "hs", R"({"hue":{{ hue }},"saturation":{{ sat }}})", "{{ value_json.hue }},{{ value_json.saturation }}");
  if (const auto* rgb = parts.partner(main, {"colourRgb"}))
    add(*rgb, "rgb", "{{ '#%02x%02x%02x' % (red, green, blue) }}",
        "{{ value[1:3] | int(base=16) }},{{ value[3:5] | int(base=16) }},{{ value[5:7] | int(base=16) }}");
}

void add_lights(Parts& parts) {
  while (const auto* lamp = parts.next("lamp")) {
    auto body = commanded(*lamp);
    body["pl_on"] = on_word(*lamp);
    body["pl_off"] = lamp->about->words.empty() ? "off" : lamp->about->words.front().text;
    if (const auto* dimmer = parts.partner(*lamp, {"dimmer", "lightLevel"})) add_brightness(*dimmer, body);
    add_white(parts, *lamp, body);
    add_colour(parts, *lamp, body);
    parts.add("light", *lamp, std::move(body));
  }
  while (const auto* dimmer = parts.next("dimmer")) {
    auto body = commanded(*dimmer);
    body["stat_val_tpl"] = "{{ 'on' if value | float(0) > 0 else '0' }}";
    body["pl_on"] = "on";
    body["pl_off"] = "0";
    body["on_cmd_type"] = "brightness";
    add_brightness(*dimmer, body);
    add_white(parts, *dimmer, body);
    add_colour(parts, *dimmer, body);
    parts.add("light", *dimmer, std::move(body));
  }
}

void add_movement(const PointEntry& movement, Json& body) {
  body["cmd_t"] = set_topic(movement);
  body["pl_open"] = "up";
  body["pl_cls"] = "down";
  body["pl_stop"] = has_word(movement, "stop") ? Json("stop") : Json();
}

void add_tilt(const PointEntry& tilt, Json& body) {
  body["tilt_cmd_t"] = set_topic(tilt);
  body["tilt_status_t"] = tilt.topic();
  body["tilt_opnd_val"] = 0;
  body["tilt_clsd_val"] = 100;
}

/// Our 100 % is closed, theirs is open.
void add_covers(Parts& parts) {
  while (const auto* blind = parts.next("blindPosition")) {
    Json body{{"pos_t", blind->topic()}, {"set_pos_t", set_topic(*blind)}, {"pos_open", 0}, {"pos_clsd", 100}};
    body["opt"] = false;
    if (const auto* movement = parts.partner(*blind, {"blindMove", "upDown"})) add_movement(*movement, body);
    if (const auto* tilt = parts.partner(*blind, {"blindTilt"})) add_tilt(*tilt, body);
    body["dev_cla"] = "blind";
    parts.add("cover", *blind, std::move(body));
  }
  for (const auto type : {"blindMove", "upDown"}) {
    while (const auto* movement = parts.next(type)) {
      Json body;
      add_movement(*movement, body);
      body["dev_cla"] = "blind";
      parts.add("cover", *movement, std::move(body));
    }
  }
  for (const auto& [type, device_class] : {std::pair("damper", "damper"), std::pair("window", "window")}) {
    while (const auto* drive = parts.next(type)) {
      Json body{{"pos_t", drive->topic()}, {"set_pos_t", set_topic(*drive)}, {"pos_open", 100}, {"pos_clsd", 0}};
      body["opt"] = false;
      body["dev_cla"] = device_class;
      parts.add("cover", *drive, std::move(body));
    }
  }
}

void add_garage_doors(Parts& parts) {
  while (const auto* door = parts.next("garageDoor")) {
    auto body = commanded(*door);
    body["pl_open"] = "open";
    body["pl_cls"] = "closed";
    body["pl_stop"] = has_word(*door, "stopped") ? Json("stopped") : Json();
    body["dev_cla"] = "garage";
    parts.add("cover", *door, std::move(body));
  }
}

/// Modes that both know, in their words.
std::vector<std::string> modes_of(const PointEntry& controller) {
  std::vector<std::string> modes;
  for (const auto& word : controller.about->words) {
    for (const auto known : {"auto", "heat", "cool", "off", "dry", "fan"}) {
      if (word.text == known) modes.push_back(word.text == "fan" ? "fan_only" : word.text);
    }
  }
  return modes;
}

void add_temperatures(Parts& parts, const PointEntry& setpoint, Json& body) {
  body["temp_cmd_t"] = set_topic(setpoint);
  body["temp_stat_t"] = setpoint.topic();
  body["temp_unit"] = "C";
  if (setpoint.about->minimum) body["min_temp"] = *setpoint.about->minimum;
  if (setpoint.about->maximum) body["max_temp"] = *setpoint.about->maximum;
  body["temp_step"] = 0.5;
  if (const auto* now = parts.sensor(setpoint, "temperature")) body["curr_temp_t"] = now->topic();
}

void add_activity(Parts& parts, const PointEntry& controller, Json& body) {
  const auto* activity = parts.sensor(controller, "hvacState");
  if (activity == nullptr) return;
  body["act_t"] = activity->topic();
  body["act_tpl"] = "{{ {'heat': 'heating', 'cool': 'cooling', 'fan': 'fan'}.get(value, 'idle') }}";
}

/// A preset with the words of the device, and a fan. Their `none` is in each list of presets by itself.
void add_climate_parts(Parts& parts, const PointEntry& main, Json& body) {
  const auto add = [&](const PointEntry* point, const char* words_key, const std::string& prefix) {
    auto words = point == nullptr ? std::vector<std::string>() : words_of(*point);
    std::erase(words, "none");
    if (words.empty()) return;
    body[words_key] = words;
    body[prefix + "_cmd_t"] = set_topic(*point);
    body[prefix + "_stat_t"] = point->topic();
    parts.take(*point);
  };
  add(main.type() == "hvacMode" ? &main : parts.part(main, "climate", "preset"), "pr_modes", "pr_mode");
  add(parts.part(main, "climate", "fan"), "fan_modes", "fan_mode");
}

/// A controller without a mode that they know stays a selection.
void add_thermostats(Parts& parts, Points& written) {
  const auto is_controller = [](const PointEntry* point) {
    return (point->type() == "hvacController" || point->type() == "thermostatMode") && !modes_of(*point).empty();
  };
  for (auto at = std::find_if(written.begin(), written.end(), is_controller); at != written.end();
       at = std::find_if(written.begin(), written.end(), is_controller)) {
    const auto* controller = *at;
    written.erase(at);
    Json body{{"modes", modes_of(*controller)}, {"mode_cmd_t", set_topic(*controller)}};
    body["mode_stat_t"] = controller->topic();
    body["mode_cmd_tpl"] = "{{ 'fan' if value == 'fan_only' else value }}";
    body["mode_stat_tpl"] = "{{ 'fan_only' if value == 'fan' else value }}";
    body["opt"] = false;
    if (const auto* setpoint = parts.partner(*controller, {"temperatureSetpoint"}))
      add_temperatures(parts, *setpoint, body);
    add_climate_parts(parts, *controller, body);
    add_activity(parts, *controller, body);
    parts.add("climate", *controller, std::move(body));
  }
}

/// A room controller has a setpoint and modes such as comfort and economy, but none of heating and cooling.
void add_room_controllers(Parts& parts, Points& written) {
  const Points all = written;
  for (const auto* setpoint : all) {
    if (setpoint->type() != "temperatureSetpoint") continue;
    const auto* mode = parts.partner(*setpoint, {"hvacMode"});
    if (mode == nullptr) continue;
    parts.take(*setpoint);
    Json body{{"modes", {"auto"}}, {"mode_stat_t", mode->topic()}, {"mode_stat_tpl", "auto"}, {"opt", false}};
    add_temperatures(parts, *setpoint, body);
    add_climate_parts(parts, *mode, body);
    add_activity(parts, *mode, body);
    parts.add("climate", *mode, std::move(body));
  }
}

void add_words(const PointEntry& point, Json& body, std::initializer_list<const char*> off, Types on) {
  for (const auto* key : off) body[key] = point.about->words.empty() ? "off" : point.about->words.front().text;
  for (const auto key : on) body[std::string(key)] = on_word(point);
}

void add_locks_and_valves(Parts& parts) {
  while (const auto* lock = parts.next("lock")) {
    auto body = commanded(*lock);
    add_words(*lock, body, {"pl_unlk", "stat_unlocked"}, {"pl_lock", "stat_locked"});
    parts.add("lock", *lock, std::move(body));
  }
  while (const auto* valve = parts.next("valve")) {
    auto body = commanded(*valve);
    body["reports_position"] = true;
    parts.add("valve", *valve, std::move(body));
  }
  while (const auto* valve = parts.next("valveSwitch")) {
    auto body = commanded(*valve);
    add_words(*valve, body, {"pl_cls", "stat_clsd"}, {"pl_open", "stat_open"});
    parts.add("valve", *valve, std::move(body));
  }
}

void add_fans_and_sirens(Parts& parts) {
  while (const auto* fan = parts.next("fan")) {
    auto body = commanded(*fan);
    add_words(*fan, body, {"pl_off"}, {"pl_on"});
    if (const auto* speed = parts.partner(*fan, {"fanSpeed"})) {
      body["pct_cmd_t"] = set_topic(*speed);
      body["pct_stat_t"] = speed->topic();
    }
    parts.add("fan", *fan, std::move(body));
  }
  while (const auto* siren = parts.next("siren")) {
    auto body = commanded(*siren);
    add_words(*siren, body, {"pl_off", "stat_off"}, {"pl_on", "stat_on"});
    const auto* tone = parts.part(*siren, "siren", "tone");
    const auto tones = tone == nullptr ? std::vector<std::string>() : words_of(*tone);
    const bool lasts = parts.part(*siren, "siren", "duration") != nullptr;
    const bool is_loud = parts.part(*siren, "siren", "volume_level") != nullptr;
    if (!tones.empty()) body["av_tones"] = tones;
    const bool only_on = tones.empty() && !lasts && !is_loud;
    if (only_on) body["cmd_tpl"] = "{{ value }}";  // else it sends an object, which commands.cpp takes
    body["sup_dur"] = lasts;
    body["sup_vol"] = is_loud;
    parts.add("siren", *siren, std::move(body));
  }
}

}  // namespace

std::vector<Entity> composites_of(Points& written, Points& left) {
  Parts parts(written, left);
  add_lights(parts);
  add_covers(parts);
  add_garage_doors(parts);
  add_thermostats(parts, written);
  add_room_controllers(parts, written);
  add_locks_and_valves(parts);
  add_fans_and_sirens(parts);
  parts.name_all();
  return std::move(parts.made);
}

}  // namespace rubicon::bridges::mqtt
