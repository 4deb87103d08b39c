#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "rubicon/result.hpp"
#include "rubicon/time.hpp"

namespace rubicon::zigbee_simulator {

/// A device that was paired long ago, or one that the steps bring:
///
///     device lamp kitchen/ceiling
///     device thermometer cellar%20room every 5s      reports each five seconds; `%20` in a word is a blank
///     device random 0x00124b0010000002               any definition; without a name of its own it has its address
struct DeviceLine {
  std::string model;  ///< of model_names(), or `random`
  std::string name;
  Duration every{};
};

///     group 7 lamps kitchen/ceiling hall/lamp
struct GroupLine {
  int id = 0;
  std::string name;
  std::vector<std::string> members;
};

/// A timed line; `at` counts from the start of the simulator, or of the round after a `repeat`.
///
///     at 2s set hall/lamp state ON          the device is switched by hand and reports it
///     at 3s action remote toggle            a message with this `action`
///     at 4s report hall/lamp                it measures and reports; if it sleeps, it wakes
///     at 5s fault hall/lamp ignore          sets: ignore, refuse, silent (no power), echo-first; none ends all
///     at 6s delay hall/lamp 3s              it answers so late
///     at 7s unknown hall/lamp brightness    its value is null
///     at 8s permit 60s                      joining is permitted
///     at 9s join plug                       a device pairs, or waits until joining is permitted
///     at 9s fail plug                       the same, and its interview fails
///     at 10s burst 20                       so many random devices pair: four lists each
///     at 11s rename hall/lamp hall          as by another client
///     at 12s leave hall
///     at 13s announce hall                  it had no power for a moment
///     at 14s shorten hall                   a list without it, and a right one 200 ms later
///     at 15s say bridge/devices [{]         any message of the bridge
///     at 16s stop 10s                       the bridge ends and starts after 10 s, with copies of old states
///     at 60s repeat                         the script begins again
struct Step {
  enum class Kind : std::uint8_t {
    kSet,
    kAction,
    kReport,
    kFault,
    kDelay,
    kUnknown,
    kPermit,
    kJoin,
    kFail,
    kBurst,
    kRename,
    kLeave,
    kAnnounce,
    kShorten,
    kSay,
    kStop,
    kRepeat
  };
  Duration at{};
  Kind kind = Kind::kSet;
  std::string name{};  ///< of the device
  std::string word{};  ///< property, fault, model, new name, or topic
  std::string text{};  ///< value or payload
  Duration span{};
  int count = 0;

  int line = 0;  ///< of the file, from 1

  friend bool operator==(const Step&, const Step&) = default;
};

struct Script {
  std::vector<DeviceLine> devices;
  std::vector<GroupLine> groups;
  std::vector<Step> steps;  ///< in the order of their times
};

/// `device`, `group` and `at` lines; `#` begins a comment. kInvalid names the line and what was expected there.
Result<Script> parse_script(std::string_view text);

/// The JSON that a word spells, or the word itself as a JSON string: `ON`, `21.5`, `true`, `{"x":0.3,"y":0.3}`.
nlohmann::json value_of_word(std::string_view word);

}  // namespace rubicon::zigbee_simulator
