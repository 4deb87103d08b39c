#include "tuples/tuple_json.h"

#include <nlohmann/json.hpp>

#include "base/bytes.h"
#include "base/local_time.h"

namespace rubicon::tuples {

namespace {

using Line = nlohmann::ordered_json;

std::string text_of(const Line& line) {
  return line.dump(-1, ' ', false, Line::error_handler_t::replace);
}

void put_tuple(Line& line, const tuples::TupleView& tuple) {
  line["owner"] = number(tuple.owner);
  line["key"] = tuple.key;
  if (base::is_utf8(tuple.value)) {
    line["value"] = tuple.value;
  } else {
    line["value_hex"] = base::to_hex(base::as_bytes(tuple.value));
  }
  line["mimetype"] = tuple.media_type;
  line["seq"] = tuple.sequence;
  line["write"] = base::to_seconds(tuple.write_time);
  line["user"] = base::to_seconds(tuple.user_time);
  line["time"] = base::iso_text(tuple.user_time == WallTime{} ? tuple.write_time : tuple.user_time);
}

}  // namespace

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

}  // namespace rubicon::tuples
