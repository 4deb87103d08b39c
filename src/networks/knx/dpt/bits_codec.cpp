#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "model/key.h"
#include "networks/knx/dpt/codec.h"

namespace rubicon::networks::knx {

namespace {

using Tree = nlohmann::ordered_json;

/// Bits without a name are reserved.
std::uint64_t mask_of(const Dpt& type) {
  std::uint64_t mask = 0;
  for (const auto& word : type.words) mask |= std::uint64_t{1} << word.value;
  return mask;
}

Result<Payload> payload_of(const Dpt& type, std::int64_t raw) {
  if (raw < 0 || (static_cast<std::uint64_t>(raw) & ~mask_of(type)) != 0) {
    return fail(ErrorCode::kOutOfRange, fmt::format("{}: {} has bits without a meaning, expected some of {:#x}",
                                                    name_of(type), raw, mask_of(type)));
  }
  Payload payload{Bytes(type.bits / 8), false};
  put_bits(payload.bytes, 0, type.bits, static_cast<std::uint64_t>(raw));
  return payload;
}

/// The number under "raw" first, then the named bits on top of it.
Result<std::int64_t> raw_of(const Dpt& type, const Tree& json) {
  std::int64_t raw = 0;
  if (const auto number = json.find("raw"); number != json.end()) {
    if (!number->is_number_integer()) return fail(ErrorCode::kInvalid, name_of(type) + ": raw: expected a number");
    raw = number->get<std::int64_t>();
  }
  for (const auto& item : json.items()) {
    if (item.key() == "raw") continue;
    const auto found =
        std::ranges::find_if(type.words, [&](const Word& word) { return same_word(word.text, item.key()); });
    if (found == type.words.end() || !item.value().is_boolean()) {
      return fail(ErrorCode::kInvalid, fmt::format("{}: {}: expected the name of a bit with true or false",
                                                   name_of(type), model::quoted(item.key())));
    }
    const auto bit = std::int64_t{1} << found->value;
    raw = item.value().get<bool>() ? raw | bit : raw & ~bit;
  }
  return raw;
}

}  // namespace

Result<Value> decode_bits(const Dpt& type, ByteView bytes) {
  const auto raw = bits_at(bytes, 0, type.bits) & mask_of(type);
  Tree json{{"raw", raw}};
  for (const auto& word : type.words) json[std::string(word.text)] = (raw >> word.value & 1) != 0;
  return Value(Json{json.dump()});
}

Result<Payload> encode_bits(const Dpt& type, const Value& value) {
  if (const auto* raw = std::get_if<std::int64_t>(&value)) return payload_of(type, *raw);
  const auto* text = std::get_if<Json>(&value);
  if (!text) return wrong_kind(type, value, "JSON or a number");
  const auto json = text->text.size() > kMaxJson ? Tree() : Tree::parse(text->text, nullptr, false);
  if (!json.is_object()) return wrong_kind(type, value, "a JSON object");
  const auto raw = raw_of(type, json);
  if (!raw) return fail(raw.error());
  return payload_of(type, *raw);
}

}  // namespace rubicon::networks::knx
