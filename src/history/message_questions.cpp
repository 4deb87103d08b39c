#include "history/message_questions.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "base/bytes.h"
#include "gateway/message_rights.h"
#include "model/json_members.h"
#include "model/message_fields.h"
#include "tuples/peer_policy.h"

namespace rubicon::history {

namespace {

/// Bytes of an id, which is in the answer too.
constexpr std::size_t kMaxQuestionId = 64;

Error wrong(std::string text) {
  return {ErrorCode::kInvalid, std::move(text)};
}

Result<std::vector<SeriesName>> names_in(const std::vector<std::string>& keys) {
  if (keys.empty() || keys.size() > kMaxAsked)
    return fail(wrong(fmt::format("{} keys, expected 1 to {}", keys.size(), kMaxAsked)));
  std::vector<SeriesName> names;
  for (const auto& key : keys) {
    auto name = parse_series(key);
    if (!name) return fail(name.error());
    names.push_back(std::move(*name));
  }
  return names;
}

/// Components of the island's own process, and all where there are no rights, may read everything.
Result<void> may_read(TupleSpace& space, const Message& message, const std::vector<SeriesName>& names) {
  auto* judge = tuples::SpaceRights::judge(space);
  if (judge == nullptr || !message.sender) return {};
  const auto who = gateway::member_of(*message.sender);
  for (const auto& name : names) {
    if (judge->access(who, name.key).read) continue;
    const Result<void> refusal =
        fail(ErrorCode::kRefused, fmt::format("{} may not read {}: no rule allows it", who.name, name.key));
    judge->record(who, {message.origin, {}, "read", name.key, {}}, refusal);
    return refusal;
  }
  return {};
}

}  // namespace

MessageQuestions::MessageQuestions(TupleSpace& space, gateway::Gateway& gateway, HistorySource& source)
    : space_(space),
      gateway_(gateway),
      source_(source),
      listener_(gateway.subscribe_user(kQuestionTag, [this](const Message& message) { take(message); })) {}

/// What is wrong with a question is said to its sender, with the id as far as it could be read.
Result<Question> MessageQuestions::read(const Message& message, std::string& id) const {
  const auto& opaque = std::get<model::Opaque>(message.body);
  if (opaque.bytes.size() > model::kMaxToolRequest)
    return fail(wrong(fmt::format("{} bytes, at most {} are taken", opaque.bytes.size(), model::kMaxToolRequest)));
  const auto request = model::object_of(base::as_text(opaque.bytes));
  id = model::text_of(request, "id");
  if (id.size() > kMaxQuestionId) {
    id.clear();
    return fail(wrong(fmt::format("id: at most {} bytes are taken", kMaxQuestionId)));
  }
  if (model::text_of(request, "do") != "query") return fail(wrong("do: expected query"));
  auto names = names_in(model::texts_of(request, "keys"));
  if (!names) return fail(names.error());
  Question question{std::move(*names), model::time_of(request, "from"), model::time_of(request, "to"),
                    model::count_of(request, "buckets")};
  if (question.from >= question.to) return fail(wrong("from: expected a time before `to`"));
  if (question.buckets < 1 || question.buckets > kMaxBuckets)
    return fail(wrong(fmt::format("buckets: expected 1 to {}", kMaxBuckets)));
  if (auto may = may_read(space_, message, question.series); !may) return fail(may.error());
  return question;
}

void MessageQuestions::take(const Message& message) {
  std::string id;
  auto question = read(message, id);
  if (!question) return reply(message.source, id, fail(question.error()));
  const auto number = ++last_;
  open_[number] = source_.ask(
      std::to_string(model::number(message.source.island)), std::move(*question),
      [](const Answer& answer) { return to_json(answer); },
      [this, number, to = message.source, id](const Result<std::string>& answer) {
        reply(to, id, answer);
        open_.erase(number);
      });
}

void MessageQuestions::reply(const Address& to, const std::string& id, const Result<std::string>& answer) {
  std::string text = "{\"id\":";
  model::append_json(id, text);
  const bool fits = answer && answer->size() <= kMaxAnswer;
  if (fits) {
    text += ",\"ok\":true,\"answer\":" + *answer + '}';
  } else {
    text += ",\"ok\":false,\"why\":";
    model::append_json(answer
                           ? fmt::format("the answer has {} bytes, at most {} are sent: ask for fewer series, or for "
                                         "fewer buckets",
                                         answer->size(), kMaxAnswer)
                           : answer.error().text,
                       text);
    text += '}';
  }
  Message message;
  message.destination = to;
  const auto bytes = base::as_bytes(text);
  message.body = model::Opaque{std::string(kAnswerTag), Bytes(bytes.begin(), bytes.end())};
  gateway_.send(std::move(message));
}

namespace {

std::optional<SeriesKind> parse_kind(std::string_view word) {
  for (const auto kind : {SeriesKind::kNumber, SeriesKind::kWords, SeriesKind::kText}) {
    if (word == to_string(kind)) return kind;
  }
  return std::nullopt;
}

/// The numbers of a list; what is none is a gap.
std::vector<double> numbers_of(const nlohmann::json& tree, const char* name) {
  std::vector<double> numbers;
  const auto found = tree.find(name);
  if (found == tree.end() || !found->is_array()) return numbers;
  for (const auto& one : *found) numbers.push_back(one.is_number() ? one.get<double>() : kGap);
  return numbers;
}

std::vector<Bucket> buckets_of(const nlohmann::json& tree) {
  const bool single = tree.contains("v");
  const auto column = [&](const char* name) { return numbers_of(tree, single ? "v" : name); };
  const auto first = column("first"), least = column("min"), most = column("max"), mean = column("mean"),
             last = column("last"), counts = numbers_of(tree, "n"), times = numbers_of(tree, "t");
  std::vector<Bucket> buckets;
  for (std::size_t i = 0; i < std::min({times.size(), first.size(), least.size(), most.size(), mean.size(), last.size(),
                                        single ? times.size() : counts.size()});
       ++i) {
    const auto count = single || !(counts[i] >= 1) ? 1 : std::min(counts[i], double{UINT32_MAX});
    buckets.push_back({model::time_from_seconds(times[i]), static_cast<std::uint32_t>(count), first[i], least[i],
                       most[i], mean[i], last[i]});
  }
  return buckets;
}

}  // namespace

Result<Answer> answer_from_json(std::string_view text) {
  const auto tree = model::object_of(text);
  const auto list = tree.find("series");
  if (list == tree.end() || !list->is_array()) return fail(ErrorCode::kInvalid, "expected an answer of a history");
  Answer answer{model::time_of(tree, "from"),
                model::time_of(tree, "to"),
                std::chrono::milliseconds(std::llround(model::number_of(tree, "bucket") * 1000)),
                {}};
  for (const auto& one : *list) {
    if (!one.is_object()) continue;
    auto name = parse_series(model::text_of(one, "key"));
    const auto kind = parse_kind(model::text_of(one, "kind"));
    if (!name || !kind) return fail(ErrorCode::kInvalid, "expected key and kind of each series");
    SeriesAnswer series{std::move(*name), *kind, model::text_of(one, "unit"), model::texts_of(one, "words")};
    series.buckets = buckets_of(one);
    for (const auto& pair : one.value("texts", nlohmann::json::array())) {
      if (pair.is_array() && pair.size() == 2 && pair[0].is_number() && pair[1].is_string())
        series.texts.push_back({model::time_from_seconds(pair[0].get<double>()), pair[1].get<std::string>()});
    }
    answer.series.push_back(std::move(series));
  }
  return answer;
}

}  // namespace rubicon::history
