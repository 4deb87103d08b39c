#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "model/type_catalogue.h"
#include "rubicon/result.hpp"
#include "rubicon/time.hpp"

namespace rubicon::model {

/// A word of an enumeration, or the name of a bit in a set of bits (0 = lowest, at most 31).
struct Word {
  std::uint32_t value = 0;
  std::string text;

  friend bool operator==(const Word&, const Word&) = default;
};

/// Those of a type: `closed,open` (Type::words).
std::vector<Word> words_in(std::string_view words);

/// Text of a user -> value, by the words of one point; `words` is not empty.
///
/// An enumeration: the word, or its number; a number without a word (`7`, `reserved (7)`) stays a number. Of words
/// only letters, digits and dots count, in any case: `Not-used` means `not used`.
///
/// A set of bits (data type JSON): an object of bits by name (`{"fault": true}`; those that are missing are off, or as
/// `raw` has them), a list of the bits that are on (`["fault"]`), one bit (`fault`), or the number. Always becomes the
/// object that set_of() writes.
///
/// kInvalid names the words that there are.
Result<Value> parse_words(const Type& type, const std::vector<Word>& words, std::string_view text);

/// The number of a set of bits, from any of its forms. kInvalid says what is none of them, without naming a type.
Result<std::uint32_t> bits_of(const std::vector<Word>& words, std::string_view text);
/// A set of bits as in tuples: `{"raw":5,"fault":true,...}`, every bit by its name in the order of `words`.
Json set_of(const std::vector<Word>& words, std::uint32_t raw);

/// Without regard to the case of ASCII letters.
bool same_word(std::string_view left, std::string_view right);
/// The number in `7` and `reserved (7)`.
std::optional<std::uint32_t> number_of(std::string_view text);
/// Letters, digits and dots in small letters: `Not-used` and `not used` are the same.
std::string plain_word(std::string_view text);

/// What a text means by words of any kind (`text`, `value`): the word itself goes before a number, and that before a
/// word that is the same but for blanks and hyphens. nullopt where it is none, or could be two.
template <class Words>
std::optional<std::uint32_t> value_of_word(const Words& words, std::string_view text) {
  for (const auto& word : words) {
    if (same_word(word.text, text)) return word.value;
  }
  if (const auto number = number_of(text)) return number;
  std::optional<std::uint32_t> found;
  const auto wanted = plain_word(text);
  for (const auto& word : words) {
    if (wanted.empty() || plain_word(word.text) != wanted) continue;
    if (found) return std::nullopt;
    found = word.value;
  }
  return found;
}

/// One sensor, actuator or property of a device: kind, type and instance, always all three. The instance is what
/// follows the `-` in keys (`1`, `window`); it never shifts when another is added. A property has an empty
/// instance when it belongs to the device; else the id of the sensor or actuator it belongs to (`light-1`).
struct PointId {
  Kind kind = Kind::kSensor;
  TypeId type{};
  std::string instance;

  friend bool operator==(const PointId&, const PointId&) = default;
  friend auto operator<=>(const PointId&, const PointId&) = default;
};

/// What a device says it can do at one point. Empty fields mean: as the type says.
struct Capability {
  PointId point;
  std::string type_name;  ///< needed where the catalogue does not know point.type (a foreign or newer peer's type)
  Access access = Access::kRead;
  std::string unit;
  std::optional<double> minimum;
  std::optional<double> maximum;
  /// Of an enumeration or a set of bits; sorted by value, none empty. Empty: those of the type. Commands must be
  /// one of them; a number that has no word is a command only where the point has bounds.
  std::vector<Word> words;
  /// Longest normal silence of this point; zero = never stale (reports only changes). Absent: the proxy's rule.
  std::optional<Duration> deadline;
  /// False for an actuator that never reports its state: a command then ends assumed, not confirmed.
  bool reports = true;
  /// An actuator whose state must be requested: Sample names it like a sensor.
  bool sampled = false;
  /// Value a network knows already at the join (a property's configured value); monostate = none.
  Value initial;
  // Of an open type only, which the catalogue does not know (open_type()).
  std::optional<DataType> data{};  ///< absent: numbers and texts as they come
  Report report = Report::kState;

  friend bool operator==(const Capability&, const Capability&) = default;
};

}  // namespace rubicon::model

namespace rubicon {

using model::Access;
using model::Capability;
using model::PointId;

}  // namespace rubicon
