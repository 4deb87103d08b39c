#include "web/api/tuple_forms.h"

#include <fmt/format.h>

#include "base/append.h"
#include "base/base64.h"
#include "base/printable.h"
#include "model/json_members.h"

namespace rubicon::web::api {

namespace {

void append_media(const TupleView& tuple, std::string& out) {
  out += "\"m\":";
  model::append_json(tuple.media_type, out);
}

void append_origin(const TupleView& tuple, std::string& out) {
  base::append(out, ",\"c\":{},\"w\":", number(tuple.creator));
  model::append_seconds(tuple.write_time, out);
  out += ",\"e\":";
  model::append_seconds(tuple.expire_time, out);
  out += tuple.owner_present ? ",\"p\":true" : ",\"p\":false";
}

}  // namespace

WallTime time_of(const TupleView& tuple) {
  return tuple.user_time == WallTime{} ? tuple.write_time : tuple.user_time;
}

void append_update(const TupleView& tuple, bool full, std::string& out) {
  const bool sent = tuple.value.size() <= kMaxSentValue && base::is_utf8(tuple.value);
  if (sent) {
    model::append_json(tuple.value, out);
  } else {
    out += "null";
  }
  base::append(out, ",{},", tuple.sequence);
  model::append_seconds(time_of(tuple), out);
  if (sent && !full) return;
  out += ",{";
  if (!sent) base::append(out, "\"size\":{},", tuple.value.size());
  append_media(tuple, out);
  if (full) append_origin(tuple, out);
  out += '}';
}

nlohmann::ordered_json whole_tuple(const TupleView& tuple) {
  nlohmann::ordered_json tree;
  tree["owner"] = number(tuple.owner);
  tree["key"] = tuple.key;
  const bool is_text = base::is_utf8(tuple.value);
  tree[is_text ? "value" : "b64"] = is_text ? std::string(tuple.value) : base::to_base64(tuple.value);
  tree["media"] = tuple.media_type;
  tree["creator"] = number(tuple.creator);
  tree["sequence"] = tuple.sequence;
  tree["write"] = model::seconds_json(tuple.write_time);
  tree["user"] = model::seconds_json(tuple.user_time);
  tree["expire"] = model::seconds_json(tuple.expire_time);
  tree["present"] = tuple.owner_present;
  return tree;
}

}  // namespace rubicon::web::api
