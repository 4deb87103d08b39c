#include "networks/salad/salad_codec.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "base/text.h"

namespace rubicon::networks::salad {

namespace {

constexpr std::string_view kUpdates = "#SALADST#";
constexpr std::string_view kRequest = "#SALAD#";
constexpr std::string_view kDigits = "0123456789";
/// Where doubles hold no int64 any more.
constexpr double kTooLarge = 9223372036854775808.0;

template <class Number>
std::optional<Number> whole(std::string_view text) {
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

/// Takes the digits at the front.
std::string_view take_digits(std::string_view& text) {
  const auto digits = text.substr(0, text.find_first_not_of(kDigits));
  text.remove_prefix(digits.size());
  return digits;
}

/// A number in its parts, as it is written.
struct Decimal {
  std::string_view before, after;  ///< the point
  std::string_view exponent;       ///< with its sign
  bool negative = false;
  bool plain_whole = false;  ///< neither point nor exponent
};

std::optional<Decimal> take_apart(std::string_view text) {
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

/// What no double holds is either far too small, which is zero, or far too large.
bool vanishes(const Decimal& parts) {
  constexpr std::int64_t kFar = 1'000'000;  // longer than any datagram: what stands in it cannot make up for this
  auto text = parts.exponent;
  const bool negative = text.starts_with('-');
  if (negative || text.starts_with('+')) text.remove_prefix(1);
  const auto written = text.empty() ? 0 : std::min(whole<std::int64_t>(text).value_or(kFar), kFar);
  const auto exponent = negative ? -written : written;
  if (const auto first = parts.before.find_first_not_of('0'); first != parts.before.npos)
    return exponent + static_cast<std::int64_t>(parts.before.size() - first) < 0;
  const auto first = parts.after.find_first_not_of('0');
  return first == parts.after.npos || exponent - static_cast<std::int64_t>(first) < 0;
}

std::optional<Value> number_of(const Decimal& parts, std::string_view text) {
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error == std::errc::result_out_of_range) {
    if (!vanishes(parts)) return std::nullopt;
    number = 0;
  }
  if (std::floor(number) == number && std::abs(number) < kTooLarge) return Value(static_cast<std::int64_t>(number));
  return Value(number);
}

/// Whole numbers without end stay as they are written, but for zeros in front.
Value digits_of(const Decimal& parts) {
  auto digits = parts.before;
  digits.remove_prefix(std::min(digits.find_first_not_of('0'), digits.size() - 1));
  return Value(fmt::format("{}{}", parts.negative ? "-" : "", digits));
}

/// One item, or the fault that keeps it from being one.
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

/// The items up to the next `#`, or to the end; `last` is whether the last one that was there can be read.
void read_items(std::string_view text, Datagram& out, bool& last) {
  while (!text.empty()) {
    const auto colon = std::min(text.find(':'), text.size());
    const auto one = base::trimmed(text.substr(0, colon));
    text.remove_prefix(std::min(colon + 1, text.size()));
    if (one.empty()) continue;
    Item item;
    const auto fault = read_item(one, item);
    last = !fault;
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
  bool last = false;
  for (std::size_t at = 0; at != text.npos; at = text.find(kUpdates, at)) {
    at += kUpdates.size();
    const auto end = std::min(text.find('#', at), text.size());
    read_items(text.substr(at, end - at), out, last);
    at = end;
  }
  if (count(out) == 0) ++out.faults[Fault::kEmpty];
  if (text.size() >= buffer && last) {
    out.items.pop_back();
    ++out.faults[Fault::kCut];
  }
  return out;
}

std::optional<DeviceId> read_id(std::string_view text) {
  if (text.empty() || text.find_first_not_of(kDigits) != text.npos) return std::nullopt;
  const auto id = whole<DeviceId>(text);
  return id && *id > 0 ? id : std::nullopt;
}

std::optional<Value> read_number(std::string_view text) {
  const auto parts = take_apart(text);
  if (!parts) return std::nullopt;
  if (text.starts_with('+')) text.remove_prefix(1);
  if (!parts->plain_whole) return number_of(*parts, text);
  if (const auto number = whole<std::int64_t>(text)) return Value(*number);
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
  const auto value = whole<std::int64_t>(text.substr(last + 1));
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
