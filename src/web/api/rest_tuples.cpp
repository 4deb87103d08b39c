#include <fmt/format.h>

#include "base/bytes.h"
#include "client/json_forms.h"
#include "web/api/event_stream.h"
#include "web/api/media_type.h"
#include "web/api/page_of.h"
#include "web/api/route.h"
#include "web/api/tuple_read.h"
#include "web/error_response.h"

namespace rubicon::web::api {

namespace {

constexpr Duration kLongestInterval = std::chrono::hours(24);

std::string name_of_tuple(const client::Tuple& tuple) {
  return fmt::format("{}:{}", number(tuple.owner), tuple.key);
}

/// The bytes of a value. The headers keep a browser from taking them for something else.
Response raw_response(const client::Tuple& tuple) {
  const auto type = safe_type(tuple.media_type);
  Response response{.status = 200, .content_type = type.media_type, .body = tuple.value, .headers = {}, .stream = {}};
  if (!type.is_shown) response.headers.emplace_back("Content-Disposition", "attachment");
  return response;
}

/// How a client wants a tuple.
enum class Form { kJson, kText, kRaw };

Form form_of(Call& call) {
  if (call.query.flag("raw")) return Form::kRaw;
  if (call.accepts("text/plain")) return Form::kText;
  return Form::kJson;
}

/// A client that accepts pictures, or the very type of the value, and no JSON gets the bytes.
bool wants_bytes(std::string_view accept, std::string_view media_type) {
  if (accept.find("json") != accept.npos) return false;
  const bool is_picture = media_type.starts_with("image/") && accept.find("image/") != accept.npos;
  return is_picture || (!media_type.empty() && accept.find(media_type) != accept.npos);
}

Response tuple_response(const client::Tuple& tuple, Form form, std::string_view accept) {
  if (form == Form::kRaw || wants_bytes(accept, tuple.media_type)) return raw_response(tuple);
  if (form == Form::kText)
    return {.status = 200, .content_type = "text/plain", .body = tuple.value, .headers = {}, .stream = {}};
  return json_response(client::whole_tuple_json(tuple));
}

FeedOptions read_feed_options(Query& query) {
  FeedOptions options;
  options.pattern = query.pattern("pattern");
  options.minimum = query.duration("min", options.minimum, kLongestInterval);
  options.maximum = query.duration("max", options.maximum, kLongestInterval);
  options.dead_band = query.number("deadband", 0, 0, 1e300);
  options.active = query.flag("active");
  return options;
}

std::unique_ptr<Exchange> stream_tuples(Call& call, const FeedOptions& options) {
  if (options.active) {
    const auto owner = options.pattern.owner.value_or(model::kNoOwner);
    const auto good = call.context.permission.check_read(call.request.caller, Verb::kWake, owner, options.pattern.key);
    if (!good) return call.refuse(good.error());
  }
  Response response{.status = 200, .content_type = "text/event-stream", .body = {}, .headers = {}, .stream = {}};
  response.stream = [&context = call.context, options, caller = call.request.caller](ConversationCalls calls) {
    return std::make_unique<EventStream>(context, caller, options, std::move(calls));
  };
  return call.answer(std::move(response));
}

}  // namespace

std::unique_ptr<Exchange> list_tuples(Call& call) {
  const auto options = read_feed_options(call.query);
  const auto range = read_range(call.query);
  if (auto good = call.may_read(options.pattern); !good) return call.refuse(good.error());
  if (call.accepts("text/event-stream")) return stream_tuples(call, options);
  return call.read(std::vector{options.pattern}, [range, request = call.request](std::vector<client::Tuple> tuples) {
    return json_response(page_of("tuples", std::move(tuples), request, range, name_of_tuple, client::whole_tuple_json));
  });
}

std::unique_ptr<Exchange> get_tuple(Call& call) {
  const auto owner = owner_of(call.parts[0]);
  if (!owner) return call.refuse(owner.error());
  if (auto good = model::check_key(call.parts[1]); !good) return call.refuse(good.error());
  const auto form = form_of(call);
  call.query.text("sequence");  // makes the address of each value another one, for caches
  const Pattern one{*owner, call.parts[1]};
  if (auto good = call.may_read(one); !good) return call.refuse(good.error());
  return call.read(std::vector{one}, [one, form, accept = std::string(call.request.header("accept"))](
                                         const std::vector<client::Tuple>& tuples) {
    if (tuples.empty()) return error_response({ErrorCode::kNotFound, fmt::format("no tuple {}", to_string(one))});
    return tuple_response(tuples.front(), form, accept);
  });
}

}  // namespace rubicon::web::api
