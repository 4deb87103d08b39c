#include "web/api/forms.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <string>

#include "base/bytes.h"
#include "base/text.h"
#include "model/json_members.h"
#include "rubicon/summary.hpp"
#include "verbs/answers.h"
#include "verbs/requests.h"

namespace rubicon::web::api {

nlohmann::ordered_json component_json(OwnerId id, std::string_view summary) {
  const auto about = model::summary_from_json(summary).value_or(Summary{});
  const auto blank = about.program.rfind(' ');  // `rubicon-proxy 0.1.0`
  nlohmann::ordered_json line;
  line["id"] = number(id);
  line["name"] = about.name;
  line["host"] = about.host;
  line["program"] = about.program.substr(0, blank);
  line["version"] = blank == std::string::npos ? "" : about.program.substr(blank + 1);
  if (model::is_island(id, about)) {
    line["prefix"] = about.prefix;
    line["networks"] = about.networks;
    line["devices"] = std::accumulate(about.networks.begin(), about.networks.end(), std::uint64_t{0},
                                      [](std::uint64_t sum, const auto& network) { return sum + network.second; });
  }
  line["since"] = base::to_seconds(about.since);
  return line;
}

nlohmann::ordered_json components_json(const TupleSpace& space, bool islands_only) {
  auto list = nlohmann::ordered_json::array();
  for (const auto id : space.peers()) {
    const auto summary = space.summary(id);
    const bool is_island = model::is_island(id, model::summary_from_json(summary).value_or(Summary{}));
    if (!islands_only || is_island) list.push_back(component_json(id, summary));
  }
  return list;
}

bool IslandPrefixes::fit(OwnerId owner, std::string_view key) {
  if (!model::is_island(owner)) return false;
  const auto [at, is_new] = beginnings_.try_emplace(owner);
  if (is_new) {
    const auto about = model::summary_from_json(space_.summary(owner)).value_or(Summary{});
    if (!about.prefix.empty()) at->second = about.prefix + ".";
  }
  return !at->second.empty() && key.starts_with(at->second);
}

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

nlohmann::ordered_json tuple_json(const client::Tuple& tuple) {
  return verbs::tuple_json({tuple.owner, tuple.key, tuple.value, tuple.media_type, tuple.creator, tuple.sequence,
                            tuple.write_time, tuple.user_time, tuple.expire_time, tuple.owner_present});
}

SafeType safe_type(std::string_view media_type) {
  constexpr const char* kBytes = "application/octet-stream";
  constexpr std::array<std::string_view, 9> kShown{"text/plain", "application/json", "image/png",
                                                   "image/jpeg", "image/gif",        "image/webp",
                                                   "image/bmp",  "image/avif",       "application/cbor"};
  const auto type = verbs::media_type_of(media_type);
  if (!type) return {kBytes, false};
  if (std::find(kShown.begin(), kShown.end(), *type) != kShown.end()) return {*type, true};
  // Pictures in a page run no scripts; opened by itself, an SVG picture would.
  if (type->starts_with("image/") || type->starts_with("audio/") || type->starts_with("video/")) return {*type, false};
  return {kBytes, false};
}

}  // namespace rubicon::web::api
