#include "tuples/tuple_json.h"

#include "base/bytes.h"
#include "base/clocks.h"
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

}  // namespace rubicon::tuples
