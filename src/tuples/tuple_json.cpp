#include "tuples/tuple_json.h"

#include "base/bytes.h"
#include "base/local_time.h"
#include "model/json_members.h"

namespace rubicon::tuples {

using Line = nlohmann::ordered_json;

std::string value_text(const TupleView& tuple) {
  return base::is_utf8(tuple.value) ? std::string(tuple.value) : base::to_hex(base::as_bytes(tuple.value));
}

Line tuple_json(const TupleView& tuple) {
  Line line;
  line["owner"] = number(tuple.owner);
  line["key"] = tuple.key;
  line[base::is_utf8(tuple.value) ? "value" : "value_hex"] = value_text(tuple);
  line["mimetype"] = tuple.media_type;
  line["seq"] = tuple.sequence;
  line["write"] = base::to_seconds(tuple.write_time);
  line["user"] = base::to_seconds(tuple.user_time);
  line["time"] = base::iso_text(tuple.user_time == WallTime{} ? tuple.write_time : tuple.user_time);
  return line;
}

std::string event_line(const tuples::Event& event, std::string_view through) {
  auto line = tuple_json(event.tuple);
  if (!through.empty()) line["through"] = through;
  line["event"] = to_string(event.kind);
  return model::dump(line);
}

std::string tuple_line(const tuples::TupleView& tuple) {
  Line line;
  line["ok"] = true;
  line.update(tuple_json(tuple));
  line["creator"] = number(tuple.creator);
  return model::dump(line);
}

std::string error_line(const Error& error) {
  Line line;
  line["ok"] = false;
  line["error"] = {{"code", to_string(error.code)}, {"text", error.text}};
  return model::dump(line);
}

}  // namespace rubicon::tuples
