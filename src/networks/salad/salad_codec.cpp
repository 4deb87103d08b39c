#include "networks/salad/salad_codec.h"

#include <fmt/format.h>

#include <cmath>

#include "base/text.h"

namespace rubicon::networks::salad {

namespace {

constexpr std::string_view kUpdates = "#SALADST#";
constexpr std::string_view kRequest = "#SALAD#";
constexpr std::string_view kDigits = "0123456789";
/// From here on a double does not fit an int64.
constexpr double kTooLarge = 9223372036854775808.0;

/// Takes the digits at the front.
std::string_view take_digits(std::string_view& text) {
  const auto digits = text.substr(0, text.find_first_not_of(kDigits));
  text.remove_prefix(digits.size());
  return digits;
}

/// The parts of a number as written.
struct Decimal {
  std::string_view before, after;  ///< digits before and after the point
  std::string_view exponent;       ///< with its sign
  bool negative = false;
  bool plain_whole = false;  ///< neither point nor exponent
};

std::optional<Decimal> split_number(std::string_view text) {
  Decimal parts;
  parts.negative = text.starts_with('-');
  if (parts.negative || text.starts_with('+')) text.remove_prefix(1);
  parts.before = take_digits(text);
  parts.plain_whole = text.empty();
  if (text.starts_with('.')) {
    text.remove_prefix(1);
    parts.after = take_digits(text);
  }
  if (parts.before.empty() && parts.after.empty()) return std::nullopt;
  if (text.empty()) return parts;
  if (text[0] != 'e' && text[0] != 'E') return std::nullopt;
  parts.exponent = text.substr(1);
  auto rest = parts.exponent;
  if (rest.starts_with('-') || rest.starts_with('+')) rest.remove_prefix(1);
  if (take_digits(rest).empty() || !rest.empty()) return std::nullopt;
  return parts;
}

/// Whether a number that fits no double is too small, which is read as zero, and not too large.
bool underflows(const Decimal& parts) {
  constexpr std::int64_t kFar = 1'000'000;  // more than the digits of any datagram can compensate
  auto text = parts.exponent;
  const bool negative = text.starts_with('-');
  if (negative || text.starts_with('+')) text.remove_prefix(1);
  const auto written = text.empty() ? 0 : std::min(base::parse_number<std::int64_t>(text).value_or(kFar), kFar);
  const auto exponent = negative ? -written : written;
  if (const auto first = parts.before.find_first_not_of('0'); first != parts.before.npos)
    return exponent + static_cast<std::int64_t>(parts.before.size() - first) < 0;
  const auto first = parts.after.find_first_not_of('0');
  return first == parts.after.npos || exponent - static_cast<std::int64_t>(first) < 0;
}

std::optional<Value> number_of(const Decimal& parts, std::string_view text) {
  const auto parsed = base::parse_number<double>(text);
  if (!parsed && !underflows(parts)) return std::nullopt;
  const double number = parsed.value_or(0);
  if (std::floor(number) == number && std::abs(number) < kTooLarge) return Value(static_cast<std::int64_t>(number));
  return Value(number);
}

/// Whole numbers of any length stay as written, without leading zeros.
Value digits_of(const Decimal& parts) {
  auto digits = parts.before;
  digits.remove_prefix(std::min(digits.find_first_not_of('0'), digits.size() - 1));
  return Value(fmt::format("{}{}", parts.negative ? "-" : "", digits));
}

/// Reads one item, or returns why it is none.
std::optional<Fault> read_item(std::string_view text, Item& item) {
  const auto semicolon = text.find(';');
  if (semicolon == text.npos || text.find(';', semicolon + 1) != text.npos) return Fault::kForm;
  const auto id = read_id(base::trimmed(text.substr(0, semicolon)));
  if (!id) return Fault::kId;
  auto value = read_number(base::trimmed(text.substr(semicolon + 1)));
  if (!value) return Fault::kValue;
  item = {*id, std::move(*value)};
  return std::nullopt;
}

/// Reads the items of one list. `last_is_sound`: whether the last one could be read; unchanged if there is none.
void read_items(std::string_view text, Datagram& out, bool& last_is_sound) {
  while (!text.empty()) {
    const auto colon = std::min(text.find(':'), text.size());
    const auto one = base::trimmed(text.substr(0, colon));
    text.remove_prefix(std::min(colon + 1, text.size()));
    if (one.empty()) continue;
    Item item;
    const auto fault = read_item(one, item);
    last_is_sound = !fault;
    if (fault) {
      ++out.faults[*fault];
    } else {
      out.items.push_back(std::move(item));
    }
  }
}

std::uint64_t count(const Datagram& datagram) {
  std::uint64_t sum = datagram.items.size();
  for (const auto& [fault, times] : datagram.faults) sum += times;
  return sum;
}

}  // namespace

std::string_view to_string(Fault fault) {
  switch (fault) {
    case Fault::kNotSalad: return "dropped-not-salad";
    case Fault::kEmpty: return "dropped-empty";
    case Fault::kForm: return "dropped-bad-form";
    case Fault::kId: return "dropped-bad-id";
    case Fault::kValue: return "dropped-bad-number";
    case Fault::kCut: return "dropped-cut";
  }
  return "dropped";
}

Datagram read_datagram(ByteView bytes, std::size_t buffer) {
  Datagram out;
  const auto text = base::as_text(bytes);
  if (!text.starts_with(kUpdates)) {
    ++out.faults[Fault::kNotSalad];
    return out;
  }
  bool last_is_sound = false;
  for (std::size_t at = 0; at != text.npos; at = text.find(kUpdates, at)) {
    at += kUpdates.size();
    const auto end = std::min(text.find('#', at), text.size());
    read_items(text.substr(at, end - at), out, last_is_sound);
    at = end;
  }
  if (count(out) == 0) ++out.faults[Fault::kEmpty];
  if (text.size() >= buffer && last_is_sound) {
    out.items.pop_back();
    ++out.faults[Fault::kCut];
  }
  return out;
}

std::optional<DeviceId> read_id(std::string_view text) {
  if (text.empty() || text.find_first_not_of(kDigits) != text.npos) return std::nullopt;
  const auto id = base::parse_number<DeviceId>(text);
  return id && *id > 0 ? id : std::nullopt;
}

std::optional<Value> read_number(std::string_view text) {
  const auto parts = split_number(text);
  if (!parts) return std::nullopt;
  if (text.starts_with('+')) text.remove_prefix(1);
  if (!parts->plain_whole) return number_of(*parts, text);
  if (const auto number = base::parse_number<std::int64_t>(text)) return Value(*number);
  return digits_of(*parts);
}

std::string actuate(std::string_view actuator, std::int64_t value) {
  return fmt::format("#SALAD#2:{}:{}:0#END#", actuator, value);
}

std::optional<Request> read_request(ByteView bytes) {
  auto text = base::as_text(bytes);
  if (text == kStartUpdates) return Request{Request::Kind::kStart, {}, 0};
  if (text == kStopUpdates) return Request{Request::Kind::kStop, {}, 0};
  constexpr std::string_view kEnd = ":0#END#";
  if (!text.starts_with(kRequest) || !text.ends_with(kEnd) || text.size() < kRequest.size() + kEnd.size())
    return std::nullopt;
  text = text.substr(kRequest.size(), text.size() - kRequest.size() - kEnd.size());
  const auto first = text.find(':'), last = text.rfind(':');
  if (first == text.npos || first == last || text.substr(0, first) != "2") return std::nullopt;
  const auto value = base::parse_number<std::int64_t>(text.substr(last + 1));
  if (!value) return std::nullopt;
  return Request{Request::Kind::kActuate, std::string(text.substr(first + 1, last - first - 1)), *value};
}

std::string write_datagram(const std::vector<Item>& items) {
  std::string text(kUpdates);
  for (const auto& item : items) {
    if (text.size() > kUpdates.size()) text += ':';
    text += fmt::format("{};{}", item.id, model::to_text(item.value));
  }
  return text + "#END#";
}

}  // namespace rubicon::networks::salad
