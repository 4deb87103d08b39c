#include "web/api/feed_writer.h"

#include <fmt/format.h>

#include <utility>

#include "base/append.h"
#include "model/json_members.h"
#include "tuples/tuple_json.h"
#include "web/api/tuple_forms.h"

namespace rubicon::web::api {

std::string SocketWriter::update(const TupleView& tuple) const {
  std::string text;
  append_update(tuple, full_, text);
  return text;
}

void SocketWriter::presence(const std::vector<OwnerId>& owners, bool absent) {
  std::string ids;
  for (const auto owner : owners) base::append(ids, "{}{}", ids.empty() ? "" : ",", number(owner));
  base::append(head_, ",\"{}\":[{}]", absent ? "absent" : "present", ids);
}

void SocketWriter::set(OwnerId owner, std::string_view key, std::uint32_t number, bool introduce,
                       std::string_view update) {
  if (introduce) {
    base::append(keys_, "{}\"{}\":\"{}:{}\"", keys_.empty() ? "" : ",", number, model::number(owner), key);
  }
  base::append(sets_, "{}[{},{}]", sets_.empty() ? "" : ",", number, update);
}

void SocketWriter::gone(OwnerId, std::string_view, std::uint32_t number, EventKind how) {
  base::append(gone_, "{}[{},\"{}\"]", gone_.empty() ? "" : ",", number, to_string(how));
}

void SocketWriter::snapshot(OwnerId owner) {
  base::append(tail_, ",\"snapshot\":{}", number(owner));
}

std::string SocketWriter::finish() {
  if (size() + tail_.size() == 0) return {};
  auto text = fmt::format("{{\"s\":{}{}", subscription_, std::exchange(head_, {}));
  const auto put = [&text](std::string_view name, char open, std::string&& content, char close) {
    if (!content.empty()) base::append(text, ",\"{}\":{}{}{}", name, open, content, close);
    content.clear();
  };
  put("k", '{', std::move(keys_), '}');
  put("set", '[', std::move(sets_), ']');
  put("gone", '[', std::move(gone_), ']');
  text += std::exchange(tail_, {});
  return text + '}';
}

std::string SocketWriter::lost(std::uint64_t events) {
  return fmt::format(R"({{"lost":{{"s":{},"events":{}}}}})", subscription_, events);
}

std::string StreamWriter::update(const TupleView& tuple) const {
  if (tuple.value.size() <= kMaxSentValue) return model::dump(tuples::tuple_json(tuple));
  auto short_tuple = tuple;
  short_tuple.value = {};
  auto tree = tuples::tuple_json(short_tuple);
  tree["value"] = nullptr;
  tree["size"] = tuple.value.size();
  return model::dump(tree);
}

void StreamWriter::add(std::string_view event, std::string_view data) {
  base::append(text_, "event: {}\nid: {}\ndata: {}\n\n", event, ++events_, data);
}

void StreamWriter::presence(const std::vector<OwnerId>& owners, bool absent) {
  for (const auto owner : owners) add(absent ? "absent" : "present", fmt::format("{{\"owner\":{}}}", number(owner)));
}

void StreamWriter::set(OwnerId, std::string_view, std::uint32_t, bool, std::string_view update) {
  add("set", update);
}

void StreamWriter::gone(OwnerId owner, std::string_view key, std::uint32_t, EventKind how) {
  add(to_string(how), fmt::format("{{\"owner\":{},\"key\":\"{}\"}}", number(owner), key));
}

void StreamWriter::snapshot(OwnerId owner) {
  add("snapshot", fmt::format("{{\"owner\":{}}}", number(owner)));
}

std::string StreamWriter::finish() {
  return std::exchange(text_, {});
}

std::string StreamWriter::lost(std::uint64_t events) {
  add("lost", fmt::format("{{\"events\":{}}}", events));
  return finish();
}

}  // namespace rubicon::web::api
