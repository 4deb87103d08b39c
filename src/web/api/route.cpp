#include "web/api/route.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <tuple>
#include <utility>

#include "base/text.h"
#include "model/json_members.h"
#include "web/exchange.h"
#include "web/server/http_text.h"

namespace rubicon::web::api {

namespace {

constexpr Duration kPatience = std::chrono::seconds(3);

}  // namespace

TupleRead::TupleRead(Context& context, const std::vector<Pattern>& patterns, Make make, Respond respond)
    : open_(patterns.size()), make_(std::move(make)), respond_(std::move(respond)) {
  for (const auto& pattern : patterns) {
    queries_.push_back(std::make_unique<client::TupleQuery>(
        context.scheduler, context.space, context.peers, pattern,
        [this](std::vector<client::Tuple> some) { add(std::move(some)); }, kPatience));
  }
}

void TupleRead::add(std::vector<client::Tuple> some) {
  std::move(some.begin(), some.end(), std::back_inserter(tuples_));
  if (--open_ > 0) return;
  if (queries_.size() > 1) merge();
  const auto respond = std::move(respond_);
  respond(make_(std::move(tuples_)));  // may destroy this
}

/// A tuple may match several patterns.
void TupleRead::merge() {
  const auto place = [](const client::Tuple& tuple) { return std::tie(tuple.owner, tuple.key); };
  std::sort(tuples_.begin(), tuples_.end(), [&](const auto& a, const auto& b) { return place(a) < place(b); });
  const auto same = [&](const auto& a, const auto& b) { return place(a) == place(b); };
  tuples_.erase(std::unique(tuples_.begin(), tuples_.end(), same), tuples_.end());
}

namespace {

/// `application/json;q=0.9` -> `application/json`
std::string_view without_parameters(std::string_view media_range) {
  return base::trimmed(media_range.substr(0, media_range.find(';')));
}

/// The text before the next `/`, which is removed as well.
std::string_view take_part(std::string_view& path) {
  const auto end = path.find('/');
  const auto part = path.substr(0, end);
  path.remove_prefix(end == path.npos ? path.size() : end + 1);
  return part;
}

}  // namespace

std::unique_ptr<Exchange> Call::refuse(const Error& error) const {
  if (error.code == ErrorCode::kBusy) ++context.counters.busy;
  return answer(error_response(error));
}

std::unique_ptr<Exchange> Call::answer(Response response) const {
  respond(std::move(response));
  return nullptr;
}

Result<void> Call::may_read(const Pattern& pattern) {
  if (auto good = query.end(); !good) return good;
  return context.permission.check_read(request.caller, Verb::kRead, pattern.owner.value_or(model::kNoOwner),
                                       pattern.key);
}

std::unique_ptr<Exchange> Call::read(const std::vector<Pattern>& patterns, TupleRead::Make make) const {
  const bool counts = !std::all_of(patterns.begin(), patterns.end(), [](const auto& one) { return one.exact(); });
  const auto name = caller_name();
  if (counts && !context.lists.take(name, context.scheduler.now()))
    return refuse({ErrorCode::kBusy, "more than 30 lists, or 600,000 tuples of lists, in a second"});
  auto counted = [&all = context, name, counts, caller = request.caller,
                  make = std::move(make)](std::vector<client::Tuple> tuples) {
    const auto cost = static_cast<double>(tuples.size()) / Context::kTuplesOfAList;
    if (counts) all.lists.charge(name, all.scheduler.now(), cost);
    if (!all.permission.sees_all(caller))
      std::erase_if(tuples, [&](const auto& one) { return !all.permission.access(caller, one.key).read; });
    return make(std::move(tuples));
  };
  return std::make_unique<TupleRead>(context, patterns, std::move(counted), respond);
}

Result<void> Call::take_command() const {
  if (context.commands.take(caller_name(), context.scheduler.now())) return {};
  return fail(ErrorCode::kBusy, fmt::format("more than {} commands in a second", Context::kCommandsPerSecond));
}

std::string caller_name_of(const Caller& caller) {
  return caller.name + "@" + caller.peer;
}

bool Call::accepts(std::string_view media_type) const {
  for (auto rest = request.header("accept"); !rest.empty();) {
    const auto comma = rest.find(',');
    if (without_parameters(rest.substr(0, comma)) == media_type) return true;
    rest.remove_prefix(comma == rest.npos ? rest.size() : comma + 1);
  }
  return false;
}

std::optional<std::vector<std::string>> match(const Route& route, std::string_view path) {
  std::string_view expected = route.path;
  std::vector<std::string> parts;
  while (!expected.empty() && !path.empty()) {
    const auto want = take_part(expected);
    const auto got = take_part(path);
    if (!want.starts_with('{')) {
      if (want != got) return std::nullopt;
      continue;
    }
    auto part = server::percent_decoded(got);
    if (!part || part->empty()) return std::nullopt;
    parts.push_back(std::move(*part));
  }
  if (!expected.empty() || !path.empty()) return std::nullopt;
  return parts;
}

Response json_response(const nlohmann::ordered_json& tree, unsigned status) {
  return {.status = status, .content_type = "application/json", .body = model::dump(tree), .headers = {}, .stream = {}};
}

std::string percent_encoded(std::string_view text) {
  std::string encoded;
  for (const char c : text) {
    const bool is_plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
                          c == '.' || c == '_' || c == '~' || c == ':' || c == '*';
    if (is_plain) {
      encoded += c;
    } else {
      base::append(encoded, "%{:02X}", static_cast<unsigned char>(c));
    }
  }
  return encoded;
}

PageRange read_range(verbs::Members& query) {
  return {query.text_or("after", ""), query.count("limit", 1, PageRange::kMaxCount).value_or(PageRange::kMaxCount)};
}

std::string next_page(const Request& request, std::string_view after) {
  auto target = request.path + "?";
  for (const auto& [name, value] : request.query) {
    if (name != "after") target += percent_encoded(name) + "=" + percent_encoded(value) + "&";
  }
  return target + "after=" + percent_encoded(after);
}

}  // namespace rubicon::web::api
