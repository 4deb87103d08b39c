#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <nlohmann/json.hpp>

#include "model/json_text.h"
#include "networks/knx/dpt/codec.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::knx::dpt {

namespace {

using Tree = nlohmann::ordered_json;

/// Payloads of the small form use the low bits of their octet.
std::size_t first_bit(const Dpt& type) {
  return type.bits < 8 ? 8U - type.bits : 0;
}

std::int64_t signed_raw(const Field& field, std::uint64_t raw) {
  const auto unused = 64 - field.bits;
  return static_cast<std::int64_t>(raw << unused) >> unused;
}

tl::unexpected<Error> wrong_field(const Dpt& type, const Field& field, std::string_view expected) {
  return fail(ErrorCode::kInvalid, fmt::format("{}: {}: expected {}", name_of(type), field.name, expected));
}

tl::unexpected<Error> field_out_of_range(const Dpt& type, const Field& field, double minimum, double maximum) {
  return fail(ErrorCode::kOutOfRange,
              fmt::format("{}: {}: expected a number from {} to {}", name_of(type), field.name, minimum, maximum));
}

/// The range of a scaled field.
struct Bounds {
  double minimum = 0, maximum = 0;
};

Bounds bounds_of(const Field& field) {
  if (field.minimum != 0 || field.maximum != 0) return {field.minimum, field.maximum};
  const double count = std::ldexp(1, field.bits);
  const double scale = field.multiply / field.divide;
  if (field.kind == FieldKind::kSigned) return {-count / 2 * scale, (count / 2 - 1) * scale};
  return {0, (count - 1) * field.multiply / field.divide};
}

Result<Tree> number_json(const Dpt& type, const Field& field, std::int64_t raw) {
  const double value = static_cast<double>(raw) * field.multiply / field.divide;
  const auto bounds = bounds_of(field);
  if (value < bounds.minimum || value > bounds.maximum) {
    return field_out_of_range(type, field, bounds.minimum, bounds.maximum);
  }
  if (field.divide == 1) return Tree(raw * static_cast<std::int64_t>(field.multiply));
  return Tree(value);
}

Result<Tree> field_json(const Dpt& type, const Field& field, std::uint64_t raw) {
  switch (field.kind) {
    case FieldKind::kFlag: return Tree(raw != 0);
    case FieldKind::kInverse: return Tree(raw == 0);
    case FieldKind::kUnsigned: return number_json(type, field, static_cast<std::int64_t>(raw));
    case FieldKind::kSigned: return number_json(type, field, signed_raw(field, raw));
    case FieldKind::kStep: return Tree(step_value(raw));
    case FieldKind::kHex: return Tree(fmt::format("{:0{}x}", raw, field.bits / 4));
    case FieldKind::kFloat16:
      // "No valid value" concerns this field only.
      if (raw == kInvalidFloat16) return Tree(nullptr);
      return Tree(float16_value(static_cast<std::uint16_t>(raw)));
    case FieldKind::kFloat32: {
      const auto value = std::bit_cast<float>(static_cast<std::uint32_t>(raw));
      if (!std::isfinite(value)) return wrong_field(type, field, "a finite number");
      return Tree(shortest_single(value));
    }
    case FieldKind::kWords: break;
  }
  const auto word = word_of(field.words, raw);
  return word.empty() ? Tree(raw) : Tree(std::string(word));
}

Result<std::uint64_t> number_raw(const Dpt& type, const Field& field, const Tree& json) {
  if (!json.is_number()) return wrong_field(type, field, "a number");
  const auto bounds = bounds_of(field);
  const double value = json.get<double>();
  if (!(value >= bounds.minimum && value <= bounds.maximum)) {
    return field_out_of_range(type, field, bounds.minimum, bounds.maximum);
  }
  if (field.divide == 1 && field.multiply == 1 && value != std::trunc(value)) {
    return wrong_field(type, field, "a whole number");
  }
  const auto raw = static_cast<std::int64_t>(std::floor(value * field.divide / field.multiply + 0.5));
  return static_cast<std::uint64_t>(raw);
}

Result<std::uint64_t> float_raw(const Dpt& type, const Field& field, const Tree& json) {
  if (field.kind == FieldKind::kFloat16 && json.is_null()) return std::uint64_t{kInvalidFloat16};
  if (!json.is_number()) return wrong_field(type, field, "a number");
  const double value = json.get<double>();
  if (field.kind == FieldKind::kFloat16) {
    const auto raw = float16_raw(value);
    if (!raw) return field_out_of_range(type, field, -671088.64, 670433.28);
    return std::uint64_t{*raw};
  }
  constexpr double kMaxSingle = std::numeric_limits<float>::max();
  if (!(value >= -kMaxSingle && value <= kMaxSingle)) return field_out_of_range(type, field, -kMaxSingle, kMaxSingle);
  return std::uint64_t{std::bit_cast<std::uint32_t>(static_cast<float>(value))};
}

Result<std::uint64_t> words_raw(const Dpt& type, const Field& field, const Tree& json) {
  const auto most = (1U << field.bits) - 1;
  std::optional<std::uint64_t> found;
  if (json.is_string()) found = word_value(field.words, json.get_ref<const std::string&>());
  if (json.is_number_unsigned()) found = json.get<std::uint64_t>();
  if (!found || *found > most) {
    std::string words;
    for (const auto& word : field.words) words.append(words.empty() ? "" : ", ").append(word.text);
    return wrong_field(type, field, fmt::format("one of {}, or a number up to {}", words, most));
  }
  return *found;
}

Result<std::uint64_t> hex_raw(const Dpt& type, const Field& field, const Tree& json) {
  const auto digits = json.is_string() ? json.get<std::string>() : std::string();
  const auto bytes = digits.find(' ') == digits.npos ? base::from_hex(digits) : Result<Bytes>(Bytes());
  if (!bytes || bytes->size() * 8 != field.bits) {
    return wrong_field(type, field, fmt::format("{} digits", field.bits / 4));
  }
  return bits_at(*bytes, 0, field.bits);
}

Result<std::uint64_t> field_raw(const Dpt& type, const Field& field, const Tree& json) {
  switch (field.kind) {
    case FieldKind::kFlag:
    case FieldKind::kInverse:
      if (!json.is_boolean()) return wrong_field(type, field, "true or false");
      return std::uint64_t{json.get<bool>() != (field.kind == FieldKind::kInverse)};
    case FieldKind::kUnsigned:
    case FieldKind::kSigned: return number_raw(type, field, json);
    case FieldKind::kFloat16:
    case FieldKind::kFloat32: return float_raw(type, field, json);
    case FieldKind::kWords: return words_raw(type, field, json);
    case FieldKind::kHex: return hex_raw(type, field, json);
    case FieldKind::kStep: break;
  }
  const auto raw = json.is_number() ? step_raw(json.get<double>()) : std::nullopt;
  if (!raw) return wrong_field(type, field, "a number from -100 to 100");
  return std::uint64_t{*raw};
}

/// Reads and writes the fields of one payload.
class RecordWriter {
 public:
  RecordWriter(const Dpt& type, const Tree& json) : type_(type), json_(json), bytes_((type.bits + 7U) / 8) {}

  Result<wire::Payload> write() {
    if (auto known = check_names(); !known) return fail(known.error());
    if (json_.empty() && type_.record->validities.empty())
      return fail(ErrorCode::kInvalid, name_of(type_) + ": expected at least one of its fields");
    for (const auto& field : type_.record->fields) {
      if (auto done = write_field(field); !done) return fail(done.error());
    }
    for (std::size_t i = 0; i < type_.record->validities.size(); ++i) {
      if (auto done = write_validity(i); !done) return fail(done.error());
    }
    return wire::Payload{std::move(bytes_), type_.bits < 8};
  }

 private:
  Result<void> check_names() const {
    for (const auto& item : json_.items()) {
      const auto same = [&](const auto& part) { return part.name == item.key(); };
      const bool known =
          std::ranges::any_of(type_.record->fields, same) || std::ranges::any_of(type_.record->validities, same);
      if (!known) {
        return fail(ErrorCode::kInvalid,
                    fmt::format("{}: unknown field {}", name_of(type_), model::quoted(item.key())));
      }
    }
    return {};
  }

  /// Fields with a validity bit may be missing: their bits, and missing flags, are then 0. So may fields that have a
  /// number for "not used".
  bool may_miss(const Field& field) const {
    return field.validity >= 0 || field.kind == FieldKind::kFloat16 ||
           (field.kind == FieldKind::kFlag && !type_.record->validities.empty());
  }

  Result<void> write_field(const Field& field) {
    const auto found = json_.find(std::string(field.name));
    if (found == json_.end()) {
      if (!may_miss(field)) return wrong_field(type_, field, "a value, but it is missing");
      if (field.kind == FieldKind::kFloat16)
        put_bits(bytes_, first_bit(type_) + field.offset, field.bits, kInvalidFloat16);
      return {};
    }
    const auto raw = field_raw(type_, field, *found);
    if (!raw) return fail(raw.error());
    put_bits(bytes_, first_bit(type_) + field.offset, field.bits, *raw);
    return {};
  }

  Result<void> write_validity(std::size_t index) {
    const auto& validity = type_.record->validities[index];
    bool any = false;
    std::string_view missing;
    for (const auto& field : type_.record->fields) {
      if (field.validity != static_cast<int>(index)) continue;
      const bool present = json_.contains(std::string(field.name));
      any = any || present;
      if (!present) missing = field.name;
    }
    const auto given = json_.find(std::string(validity.name));
    if (given != json_.end() && !given->is_boolean()) {
      return fail(ErrorCode::kInvalid, fmt::format("{}: {}: expected true or false", name_of(type_), validity.name));
    }
    const bool valid = given == json_.end() ? any : given->get<bool>();
    if (valid && !missing.empty()) {
      return fail(ErrorCode::kInvalid,
                  fmt::format("{}: {}: expected a value, but it is missing", name_of(type_), missing));
    }
    put_bits(bytes_, validity.offset, 1, valid != validity.inverse ? 1 : 0);
    return {};
  }

  const Dpt& type_;
  const Tree& json_;
  Bytes bytes_;
};

/// Invalid fields are left out, unless their bits are not all 0.
bool is_present(const Dpt& type, ByteView bytes, std::size_t index) {
  const auto& validity = type.record->validities[index];
  if ((bits_at(bytes, validity.offset, 1) != 0) != validity.inverse) return true;
  for (const auto& field : type.record->fields) {
    if (field.validity == static_cast<int>(index) && bits_at(bytes, field.offset, field.bits) != 0) return true;
  }
  return false;
}

}  // namespace

Result<Value> decode_record(const Dpt& type, ByteView bytes) {
  Tree json = Tree::object();
  for (const auto& field : type.record->fields) {
    if (field.validity >= 0 && !is_present(type, bytes, static_cast<std::size_t>(field.validity))) continue;
    auto value = field_json(type, field, bits_at(bytes, first_bit(type) + field.offset, field.bits));
    if (!value) return fail(value.error());
    json[std::string(field.name)] = std::move(*value);
  }
  for (std::size_t i = 0; i < type.record->validities.size(); ++i) {
    const auto& validity = type.record->validities[i];
    const bool valid = (bits_at(bytes, validity.offset, 1) != 0) != validity.inverse;
    if (!valid && is_present(type, bytes, i)) json[std::string(validity.name)] = false;
  }
  return Value(Json{model::dump(json)});
}

Result<wire::Payload> encode_record(const Dpt& type, const Value& value) {
  const auto* text = std::get_if<Json>(&value);
  if (!text) return wrong_kind(type, value, "JSON");
  const auto json = text->text.size() > kMaxJson ? Tree() : model::parse_ordered_json(text->text);
  if (!json.is_object()) return wrong_kind(type, value, "a JSON object");
  return RecordWriter(type, json).write();
}

Result<Value> decode_raw(const Dpt&, ByteView bytes) {
  return Value(Json{fmt::format(R"({{"raw":"{}"}})", base::to_hex(bytes))});
}

Result<wire::Payload> encode_raw(const Dpt& type, const Value& value) {
  constexpr std::string_view kExpected = "JSON like {\"raw\":\"00ff\"} of its length";
  const auto* text = std::get_if<Json>(&value);
  if (!text || text->text.size() > kMaxJson) return wrong_kind(type, value, kExpected);
  const auto json = model::parse_ordered_json(text->text);
  const bool has = json.is_object() && json.contains("raw") && json["raw"].is_string();
  auto bytes = base::from_hex(has ? json["raw"].get<std::string>() : std::string());
  if (!has || !bytes || bytes->size() * 8 != type.bits) return wrong_kind(type, value, kExpected);
  return wire::Payload{std::move(*bytes), false};
}

}  // namespace rubicon::networks::knx::dpt
