#include <fmt/format.h>

#include <utility>

#include "base/bytes.h"
#include "base/scheduler.h"
#include "verbs/answers.h"
#include "web/api/context.h"
#include "web/api/feed.h"
#include "web/api/forms.h"
#include "web/api/naming.h"
#include "web/api/route.h"
#include "web/exchange.h"

namespace rubicon::web::api {

/// A subscription as server-sent events. After kSilence without an event it sends a comment.
class EventStream final : public Conversation {
 public:
  static constexpr Duration kSilence = std::chrono::seconds(5);

  EventStream(Context& context, const Caller& caller, verbs::Subscription options, ConversationCallbacks calls);
  ~EventStream() override;

  void received(std::string_view) override {}
  std::optional<std::string> next() override;

 private:
  Context& context_;
  ConversationCallbacks callbacks_;
  EventStock stock_;
  bool comment_due_ = false;
  base::Deadline silence_;
  Feed feed_;
};

EventStream::EventStream(Context& context, const Caller& caller, verbs::Subscription options,
                         ConversationCallbacks calls)
    : context_(context),
      callbacks_(std::move(calls)),
      silence_(context.scheduler,
               [this] {
                 comment_due_ = true;
                 callbacks_.wake();
               }),
      feed_(context, caller, stock_, std::move(options), std::make_unique<StreamWriter>(),
            Feed::Callbacks{[this] { callbacks_.wake(); }, [] {}, [this](const char* why) { callbacks_.close(why); }}) {
  ++context_.counters.streams;
  silence_.set(kSilence);
}

EventStream::~EventStream() {
  --context_.counters.streams;
}

std::optional<std::string> EventStream::next() {
  auto frame = feed_.next();
  if (!frame && std::exchange(comment_due_, false)) frame = ":\n\n";
  if (!frame) return frame;
  silence_.set(kSilence);
  context_.counters.bytes_out += frame->size();
  return frame;
}

namespace {

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
  return json_response(tuple_json(tuple));
}

std::unique_ptr<Exchange> stream_tuples(Call& call, const verbs::Subscription& options) {
  if (options.active) {
    const auto owner = options.pattern.owner.value_or(model::kNoOwner);
    const auto good = call.context.permission.check_read(call.request.caller, Verb::kWake, owner, options.pattern.key);
    if (!good) return call.refuse(good.error());
  }
  Response response{.status = 200, .content_type = "text/event-stream", .body = {}, .headers = {}, .stream = {}};
  response.stream = [&context = call.context, options, caller = call.request.caller](ConversationCallbacks calls) {
    return std::make_unique<EventStream>(context, caller, options, std::move(calls));
  };
  return call.answer(std::move(response));
}

}  // namespace

std::unique_ptr<Exchange> list_tuples(Call& call) {
  if (auto later = with_key_in_query(call, "pattern", list_tuples)) return std::move(*later);
  const auto range = read_range(call.query);
  const auto options = verbs::read_subscription(call.query);
  if (!options) return call.refuse(options.error());
  if (auto good = call.may_read(options->pattern); !good) return call.refuse(good.error());
  if (call.accepts("text/event-stream")) return stream_tuples(call, *options);
  return call.read(std::vector{options->pattern}, [range, request = call.request](std::vector<client::Tuple> tuples) {
    return json_response(page_of("tuples", std::move(tuples), request, range, name_of_tuple, tuple_json));
  });
}

std::unique_ptr<Exchange> get_tuple(Call& call) {
  if (auto later = with_key_in_path(call, "value", get_tuple)) return std::move(*later);
  const auto form = form_of(call);
  call.query.has("sequence");  // makes the address of each value another one, for caches
  call.query.add("key", call.parts[0] + ":" + call.parts[1]);
  const auto one = verbs::read_get(call.query);
  if (!one) return call.refuse(one.error());
  if (auto good = call.may_read(*one); !good) return call.refuse(good.error());
  return call.read(std::vector{*one},
                   [&space = call.context.space, one = *one, form,
                    accept = std::string(call.request.header("accept"))](const std::vector<client::Tuple>& tuples) {
                     if (tuples.empty()) return error_response(verbs::no_tuple(space, one));
                     return tuple_response(tuples.front(), form, accept);
                   });
}

}  // namespace rubicon::web::api
