#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace rubicon::networks::knx::groups {

/// What a word in a name says of a group address.
enum class Sense : std::uint8_t {
  kState,     ///< reports what an actuator does: status, Rückmeldung
  kActual,    ///< the value as it is: actual, Istwert, Stellung
  kCommand,   ///< commands: command, schalten
  kSwitch,    ///< goes with commands, but a sensor may be called so too: switch, on, off
  kSetpoint,  ///< the value as it shall be: setpoint, Sollwert
  kMeasured,  ///< belongs to a sensor, stays part of the name: contact, -melder (the end of a word)
  kFiller,    ///< says nothing: of, de
};

struct SenseOfWord {
  std::string_view word;  ///< in small letters; `-melder`: every word that ends so; `aktuell-`: that begins so
  Sense sense;
};

/// The listed word table: all words that guesses go by (also in docs/knx-import.md, a test compares).
extern const std::vector<SenseOfWord> kWordTable;

/// A name taken apart.
struct NameWords {
  std::array<bool, 7> has{};
  std::string rest;   ///< its words in small letters without those of state and command, switches and fillers
  std::string stem;   ///< its rest without those of actual and set values too
  std::string shown;  ///< the words of the table in it, for the report
  bool says(Sense sense) const { return has[static_cast<std::size_t>(sense)]; }
};

NameWords words_of(std::string_view name);

}  // namespace rubicon::networks::knx::groups
