#include <fmt/format.h>

#include "history/history_source.h"
#include "model/json_text.h"
#include "web/api/naming.h"
#include "web/api/route.h"
#include "web/exchange.h"

namespace rubicon::web::api {

namespace {

/// A question to the history that is under way.
class Asking final : public Exchange {
 public:
  explicit Asking(Handle handle) : handle_(std::move(handle)) {}

 private:
  Handle handle_;
};

constexpr const char* kNoHistory =
    "no history is kept; `history: {file: home.history}` in the configuration, or `rubicon web --history FILE`, keeps "
    "one";

/// A read of the history is allowed now.
Result<void> take_read(Call& call) {
  auto& context = call.context;
  if (context.options.history == nullptr) return fail(ErrorCode::kNotFound, kNoHistory);
  const auto who = call.caller_name();
  if (context.history_reads.take(who, context.scheduler.now())) return {};
  return fail(ErrorCode::kBusy,
              fmt::format("more than {} reads of the history in a second", Context::kHistoryReadsPerSecond));
}

Result<std::vector<history::SeriesName>> read_keys(const std::vector<std::string>& texts) {
  if (texts.empty()) return fail(ErrorCode::kInvalid, "key is missing; expected OWNER:KEY");
  std::vector<history::SeriesName> names;
  for (const auto& text : texts) {
    auto name = history::parse_series(text);
    if (!name) return fail(name.error().code, "key: " + name.error().text);
    names.push_back(std::move(*name));
  }
  return names;
}

Result<history::Question> read_question(Call& call) {
  const auto now = call.context.scheduler.wall_now();
  history::Question question;
  question.to = call.query.time_or("to", now, now);
  question.from = call.query.time_or("from", question.to - std::chrono::hours(1), now);
  question.buckets = call.query.count("buckets", 1, history::kMaxBuckets).value_or(question.buckets);
  if (question.from >= question.to) call.query.fault("from: expected a time before `to`");
  const auto keys = call.query.texts("key", "OWNER:KEY", history::kMaxAsked);
  if (auto good = call.query.end(); !good) return fail(good.error());
  auto names = read_keys(keys);
  if (!names) return fail(names.error());
  question.series = std::move(*names);
  for (const auto& name : question.series) {
    const auto good = call.context.permission.check_read(call.request.caller, Verb::kRead, name.owner, name.key);
    if (!good) return fail(good.error());
  }
  return question;
}

/// Answers with the text that the history made, or with its error.
history::HistorySource::TextCall respond_with(const char* content_type, const Call& call) {
  return [content_type, respond = call.respond](Result<std::string> text) {
    if (!text) return respond(error_response(text.error()));
    respond({.status = 200, .content_type = content_type, .body = std::move(*text), .headers = {}, .stream = {}});
  };
}

history::HistorySource::SeriesText text_of_page(Request request, PageRange range) {
  return [request = std::move(request), range = std::move(range)](const std::vector<history::SeriesEntry>& series) {
    const auto name_of = [](const history::SeriesEntry& one) { return to_string(one.name); };
    const auto form_of = [](const history::SeriesEntry& one) {
      return nlohmann::ordered_json(model::parse_json(history::to_json(std::vector{one}))["series"][0]);
    };
    return model::dump(page_of("series", series, request, range, name_of, form_of));
  };
}

/// A page of series, of those that the caller may read: the name of no other is in it, nor in its `next`. The history
/// writes its pages on a thread of its own, which cannot ask the judge.
class ReadableSeries final : public Exchange {
 public:
  ReadableSeries(Call& call, Pattern pattern, PageRange range)
      : context_(call.context),
        request_(call.request),
        caller_name_(call.caller_name()),
        pattern_(std::move(pattern)),
        limit_(range.limit),
        respond_(call.respond) {
    ask({std::move(range.after), PageRange::kMaxCount});
  }

 private:
  void ask(PageRange range) {
    handle_ = context_.options.history->series(
        caller_name_, pattern_, {range.after, range.limit + 1}, text_of_page(request_, range),
        lifetime_.guard([this](Result<std::string> text) { take(std::move(text)); }));
  }

  void take(Result<std::string> text) {
    if (!text) return respond_(error_response(text.error()));  // may destroy this
    auto page = nlohmann::ordered_json(model::parse_json(*text));
    std::string last;
    for (auto& one : page["series"]) {
      last = one.value("key", "");
      const auto name = history::parse_series(last);
      if (!name || !context_.permission.access(request_.caller, name->key).read) continue;
      if (found_.size() >= limit_ || bytes_ >= PageRange::kMaxBytes) return answer(next_page(request_, last_found_));
      bytes_ += model::dump(one).size();
      last_found_ = last;
      found_.push_back(std::move(one));
    }
    if (!page.contains("next")) return answer({});
    lifetime_.post(context_.scheduler, [this, last] { ask({last, PageRange::kMaxCount}); });
  }

  void answer(const std::string& next) {
    nlohmann::ordered_json page{{"series", std::move(found_)}};
    if (!next.empty()) page["next"] = next;
    respond_(json_response(page));  // may destroy this
  }

  Context& context_;
  Request request_;
  std::string caller_name_;
  Pattern pattern_;
  std::uint64_t limit_;
  std::function<void(Response)> respond_;
  nlohmann::ordered_json found_ = nlohmann::ordered_json::array();
  std::size_t bytes_ = 0;
  std::string last_found_;
  Handle handle_;
  base::Lifetime lifetime_;
};

}  // namespace

std::unique_ptr<Exchange> read_history(Call& call) {
  if (auto later = with_key_in_query(call, "key", read_history)) return std::move(*later);
  auto question = read_question(call);
  if (!question) return call.refuse(question.error());
  if (auto good = take_read(call); !good) return call.refuse(good.error());
  const bool as_csv = call.accepts("text/csv");
  const auto text = [as_csv](const history::Answer& answer) {
    return as_csv ? history::to_csv(answer) : history::to_json(answer);
  };
  return std::make_unique<Asking>(call.context.options.history->ask(
      call.caller_name(), std::move(*question), text, respond_with(as_csv ? "text/csv" : "application/json", call)));
}

std::unique_ptr<Exchange> list_series(Call& call) {
  const auto pattern = call.query.has("pattern") ? call.query.pattern("pattern") : Pattern{std::nullopt, "**"};
  const auto range = read_range(call.query);
  if (auto good = call.may_read(pattern); !good) return call.refuse(good.error());
  if (auto good = take_read(call); !good) return call.refuse(good.error());
  if (!call.context.permission.sees_all(call.request.caller))
    return std::make_unique<ReadableSeries>(call, pattern, range);
  // One more than the page shows says that there is a next one.
  return std::make_unique<Asking>(
      call.context.options.history->series(call.caller_name(), pattern, {range.after, range.limit + 1},
                                           text_of_page(call.request, range), respond_with("application/json", call)));
}

}  // namespace rubicon::web::api
