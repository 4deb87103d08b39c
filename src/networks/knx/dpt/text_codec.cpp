#include <arpa/inet.h>
#include <fmt/format.h>

#include <algorithm>

#include "base/text.h"
#include "networks/knx/dpt/codec.h"
#include "networks/knx/wire/cemi.h"

namespace rubicon::networks::knx::dpt {

namespace {

constexpr std::size_t kMaxLongText = wire::kMaxPayload;  ///< with the NUL, which a text of full length does not have
constexpr double kLatin1 = 255;

bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

tl::unexpected<Error> undecodable(const Dpt& type, ByteView bytes, std::string_view expected) {
  return fail(ErrorCode::kInvalid, fmt::format("{}: {} is not {}", name_of(type), base::to_hex(bytes), expected));
}

/// Up to the first NUL (knx.md 9.1). Devices and ETS write ISO 8859-1 to texts in ASCII too, which it contains.
Result<Value> decode_characters(const Dpt& type, ByteView bytes) {
  const auto text = bytes.first(static_cast<std::size_t>(std::ranges::find(bytes, 0) - bytes.begin()));
  if (type.maximum > kLatin1) {
    if (!base::is_utf8(base::as_text(text))) return undecodable(type, text, "UTF-8");
    return Value(std::string(base::as_text(text)));
  }
  std::string out;
  for (const auto byte : text) {
    base::append_utf8(byte, out);
  }
  return Value(std::move(out));
}

/// One octet per character. What the code page lacks is refused: the receiver would show another text than the island.
Result<Bytes> in_code_page(const Dpt& type, const std::string& text) {
  Bytes bytes;
  for (std::string_view rest = text; !rest.empty();) {
    const auto character = base::take_utf8(rest);
    if (character == U'\0') return wrong_kind(type, text, "text without NUL");
    if (!character || *character > static_cast<char32_t>(type.maximum))
      return wrong_kind(type, text, type.maximum < kLatin1 ? "text in ASCII" : "text in ISO 8859-1");
    bytes.push_back(static_cast<std::uint8_t>(*character));
  }
  return bytes;
}

Result<wire::Payload> too_long(const Dpt& type, const std::string& text, std::size_t most) {
  return fail(ErrorCode::kOutOfRange,
              fmt::format("{}: a text of {} bytes has more than {} characters", name_of(type), text.size(), most));
}

Result<wire::Payload> encode_long(const Dpt& type, const std::string& text) {
  Bytes bytes(text.begin(), text.end());
  if (type.maximum <= kLatin1) {
    auto page = in_code_page(type, text);
    if (!page) return fail(page.error());
    bytes = std::move(*page);
  } else if (!base::is_utf8(text) || text.find('\0') != text.npos) {
    return fail(ErrorCode::kInvalid, name_of(type) + ": the text is not UTF-8 without NUL");
  }
  if (bytes.size() > kMaxLongText) return too_long(type, text, kMaxLongText);
  if (bytes.size() < kMaxLongText) bytes.push_back(0);
  return wire::Payload{std::move(bytes), false};
}

Result<wire::Payload> encode_short(const Dpt& type, const std::string& text) {
  auto bytes = in_code_page(type, text);
  if (!bytes) return fail(bytes.error());
  if (bytes->size() > type.bits / 8U) return too_long(type, text, type.bits / 8U);
  bytes->resize(type.bits / 8U);
  return wire::Payload{std::move(*bytes), false};
}

/// `de`, `CH`, and `de-CH` for both (ISO 639-1, ISO 3166-1).
Result<Value> decode_letters(const Dpt& type, ByteView bytes) {
  std::string text(base::as_text(bytes));
  if (!std::ranges::all_of(text, is_letter)) return undecodable(type, bytes, "letters");
  if (text.size() == 4) text.insert(2, "-");
  return Value(std::move(text));
}

Result<wire::Payload> encode_letters(const Dpt& type, std::string text) {
  const auto given = text;
  if (type.bits == 32 && text.size() == 5 && text[2] == '-') text.erase(2, 1);
  if (text.size() * 8 != type.bits || !std::ranges::all_of(text, is_letter)) {
    return wrong_kind(type, given, type.bits == 32 ? "language and region as in de-CH" : "two letters");
  }
  return wire::Payload{Bytes(text.begin(), text.end()), false};
}

/// Digits of `text` without one separator at `place`.
Result<wire::Payload> encode_hex(const Dpt& type, const std::string& text, std::size_t place, char separator,
                                 std::string_view expected) {
  auto digits = text;
  if (place < digits.size() && digits[place] == separator) digits.erase(place, 1);
  auto bytes = digits.find(' ') == digits.npos ? base::from_hex(digits) : Result<Bytes>(Bytes());
  if (!bytes || bytes->size() * 8 != type.bits) return wrong_kind(type, text, expected);
  return wire::Payload{std::move(*bytes), false};
}

Result<Value> decode_address(ByteView bytes) {
  char text[INET6_ADDRSTRLEN] = {};
  inet_ntop(AF_INET6, bytes.data(), text, sizeof text);
  return Value(std::string(text));
}

Result<wire::Payload> encode_address(const Dpt& type, const std::string& text) {
  wire::Payload payload{Bytes(16), false};
  if (text.find('\0') != text.npos || inet_pton(AF_INET6, text.c_str(), payload.bytes.data()) != 1) {
    return wrong_kind(type, text, "an IPv6 address");
  }
  return payload;
}

}  // namespace

Result<Value> decode_text(const Dpt& type, ByteView bytes) {
  switch (type.form) {
    case Form::kLetters: return decode_letters(type, bytes);
    case Form::kColour: return Value('#' + base::to_hex(bytes));
    case Form::kSerial: return Value(base::to_hex(bytes.first(2)) + ':' + base::to_hex(bytes.subspan(2)));
    case Form::kIpv6: return decode_address(bytes);
    default: return decode_characters(type, bytes);
  }
}

Result<wire::Payload> encode_words(const Dpt& type, const Value& value) {
  const auto* text = std::get_if<std::string>(&value);
  if (!text) return wrong_kind(type, value, "text");
  switch (type.form) {
    case Form::kLetters: return encode_letters(type, *text);
    case Form::kColour: return encode_hex(type, *text, 0, '#', "a colour as in #ff8000");
    case Form::kSerial: return encode_hex(type, *text, 4, ':', "a serial number as in 00c5:01020304");
    case Form::kIpv6: return encode_address(type, *text);
    case Form::kLongText: return encode_long(type, *text);
    default: return encode_short(type, *text);
  }
}

}  // namespace rubicon::networks::knx::dpt
