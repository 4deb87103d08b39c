#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "networks/knx/dpt/codec.h"

#include "model/json_text.h"

namespace rubicon::networks::knx::dpt {

/// Bits without a name are reserved.
Result<Value> decode_bits(const Dpt& type, ByteView bytes) {
  return Value(model::set_of(words_of(type), static_cast<std::uint32_t>(bits_at(bytes, 0, type.bits))));
}

Result<wire::Payload> encode_bits(const Dpt& type, const Value& value) {
  const auto* json = std::get_if<Json>(&value);
  if (!json && !std::holds_alternative<std::int64_t>(value)) return wrong_kind(type, value, "JSON or a number");
  const auto text = model::to_text(value);
  if (json && !model::is_json(text)) return wrong_kind(type, value, "JSON");
  const auto raw = model::bits_of(words_of(type), text);
  if (!raw) return fail(raw.error().code, name_of(type) + ": " + raw.error().text);
  wire::Payload payload{Bytes(type.bits / 8), false};
  put_bits(payload.bytes, 0, type.bits, *raw);
  return payload;
}

}  // namespace rubicon::networks::knx::dpt
