#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace rubicon::networks::knx::groups {

/// The meaning of a word in the name of a group address.
enum class Sense : std::uint8_t {
  kState,     ///< reports what an actuator does: status, Rückmeldung
  kActual,    ///< actual value: actual, Istwert, Stellung
  kCommand,   ///< commands: command, schalten
  kSwitch,    ///< found in names of commands and of sensors: switch, on, off
  kSetpoint,  ///< set value: setpoint, Sollwert
  kMeasured,  ///< sensors; the word remains part of the name: contact, -melder (the end of a word)
  kFiller,    ///< ignored: of, de
};

struct SenseOfWord {
  std::string_view
      word;  ///< in lower case; `-melder`: any word with this end; `aktuell-`: any word with this beginning
  Sense sense;
};

/// All words that infer_points() uses (a test compares them with docs/knx-import.md).
extern const std::vector<SenseOfWord> kWordTable;

/// The words of a name.
struct NameWords {
  std::array<bool, 7> has{};
  std::string rest;   ///< its words in lower case, without words for state, command and switch, and without fillers
  std::string stem;   ///< `rest` without words for actual and set values
  std::string shown;  ///< those of its words that the table has, for the report
  bool means(Sense sense) const { return has[static_cast<std::size_t>(sense)]; }
};

NameWords words_of(std::string_view name);

}  // namespace rubicon::networks::knx::groups
