#include "runtime/event_json.h"

#include <nlohmann/json.hpp>

#include "base/bytes.h"

namespace rubicon::runtime {

namespace {

using Line = nlohmann::ordered_json;

std::string text_of(const Line& line) {
  return line.dump(-1, ' ', false, Line::error_handler_t::replace);
}

void put_tuple(Line& line, const tuples::TupleView& tuple) {
  line["owner"] = number(tuple.owner);
  line["key"] = tuple.key;
  if (is_utf8(tuple.value)) {
    line["value"] = tuple.value;
  } else {
    line["value_hex"] = base::to_hex(base::as_bytes(tuple.value));
  }
  line["mimetype"] = tuple.media_type;
  line["seq"] = tuple.sequence;
  line["write"] = base::to_seconds(tuple.write_time);
  line["user"] = base::to_seconds(tuple.user_time);
}

/// Length of the UTF-8 sequence that begins with this byte (RFC 3629), 0 = none does.
std::size_t sequence_length(unsigned char first) {
  if (first < 0x80) return 1;
  if (first >= 0xc2 && first <= 0xdf) return 2;
  if (first >= 0xe0 && first <= 0xef) return 3;
  if (first >= 0xf0 && first <= 0xf4) return 4;
  return 0;
}

bool second_fits(unsigned char first, unsigned char second) {
  switch (first) {
    case 0xe0: return second >= 0xa0 && second <= 0xbf;
    case 0xed: return second >= 0x80 && second <= 0x9f;
    case 0xf0: return second >= 0x90 && second <= 0xbf;
    case 0xf4: return second >= 0x80 && second <= 0x8f;
    default: return second >= 0x80 && second <= 0xbf;
  }
}

}  // namespace

bool is_utf8(std::string_view text) {
  const auto byte = [&text](std::size_t at) { return static_cast<unsigned char>(text[at]); };
  for (std::size_t i = 0; i < text.size();) {
    const auto length = sequence_length(byte(i));
    if (length == 0 || length > text.size() - i) return false;
    if (length > 1 && !second_fits(byte(i), byte(i + 1))) return false;
    for (std::size_t j = 2; j < length; ++j) {
      if ((byte(i + j) & 0xc0U) != 0x80) return false;
    }
    i += length;
  }
  return true;
}

std::string event_line(const tuples::Event& event, std::string_view through) {
  Line line;
  put_tuple(line, event.tuple);
  if (!through.empty()) line["through"] = through;
  line["event"] = to_string(event.kind);
  return text_of(line);
}

std::string tuple_line(const tuples::TupleView& tuple) {
  Line line;
  line["ok"] = true;
  put_tuple(line, tuple);
  line["creator"] = number(tuple.creator);
  return text_of(line);
}

std::string error_line(const Error& error) {
  Line line;
  line["ok"] = false;
  line["error"] = {{"code", to_string(error.code)}, {"text", error.text}};
  return text_of(line);
}

}  // namespace rubicon::runtime
