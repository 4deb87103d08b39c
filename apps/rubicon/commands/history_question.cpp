#include "apps/rubicon/commands/history_question.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>

#include "apps/rubicon/output/tuple_text.h"
#include "apps/rubicon/targets/selection.h"
#include "apps/rubicon/targets/suggestions.h"
#include "history/history_source.h"
#include "history/message_questions.h"
#include "model/json_members.h"
#include "model/point_keys.h"

namespace rubicon::cli {

namespace {

using history::SeriesName;

/// The present tuples that are meant; of a text with an owner and a whole key also one that is gone.
int find_series(Session& session, const std::vector<std::string>& texts, std::vector<SeriesName>& found) {
  Selections selections;
  if (const int code = selections_called(session, texts, "value", selections); code != kGood) return code;
  for (const auto& selection : selections) {
    const auto tuples = session.read(selection.pattern);
    for (const auto& tuple : tuples) {
      const SeriesName name{tuple.owner, tuple.key};
      const bool known = std::find(found.begin(), found.end(), name) != found.end();
      if (!known && selection.fits(tuple.owner, tuple.key)) found.push_back(name);
    }
    if (tuples.empty() && selection.pattern.owner && selection.pattern.exact() &&
        selection.pattern.key.ends_with(".value"))
      found.push_back({*selection.pattern.owner, selection.pattern.key});
  }
  if (found.empty())
    return session.not_found(fmt::format("no tuple {}", printable(texts.back())),
                             suggest_tuple(session, texts.back(), "value"));
  if (found.size() <= history::kMaxAsked) return kGood;
  print_error(fmt::format("{} tuples fit, at most {} are asked for at once", found.size(), history::kMaxAsked));
  return kUsage;
}

/// The islands that keep a history.
std::vector<OwnerId> keepers(Session& session) {
  std::vector<OwnerId> found;
  session.discover();
  for (const auto& tuple : session.read({{}, model::IslandKey{session.settings().prefix}.history().status()}))
    found.push_back(tuple.owner);
  return found;
}

struct Asked {
  std::optional<nlohmann::json> reply;
  std::string why;
};

/// The reply of an island; a text that says why there is none.
Asked ask(Session& session, OwnerId island, const nlohmann::ordered_json& question) {
  Asked asked;
  const auto id = model::text_of(question, "id");
  const auto listener = session.client().on_message(history::kAnswerTag, [&](const client::UserMessage& message) {
    auto reply = model::object_of(message.bytes);
    if (message.from == island && model::text_of(reply, "id") == id) asked.reply = std::move(reply);
  });
  session.client().send(island, history::kQuestionTag, model::dump(question),
                        [&asked](const std::string& why) { asked.why = why; });
  const auto over = [&asked] { return asked.reply || !asked.why.empty(); };
  if (!session.run(over, session.settings().patience)) asked.why = "no answer in time";
  return asked;
}

int ask_one(Session& session, OwnerId island, const nlohmann::ordered_json& question, history::Answer& answer) {
  const auto asked = ask(session, island, question);
  const bool good = asked.reply && model::flag_of(*asked.reply, "ok");
  auto found = good ? history::answer_from_json(model::dump(asked.reply->value("answer", nlohmann::json())))
                    : fail(ErrorCode::kRefused, asked.reply ? model::text_of(*asked.reply, "why") : asked.why);
  if (!found) {
    print_error(
        fmt::format("the history of island {}: {}", session.component_text(island), printable(found.error().text)));
    return asked.reply ? kRefused : kTimedOut;
  }
  answer.from = found->from;
  answer.to = found->to;
  answer.bucket = found->bucket;
  std::move(found->series.begin(), found->series.end(), std::back_inserter(answer.series));
  return kGood;
}

}  // namespace

int ask_history(Session& session, const std::vector<std::string>& texts, WallTime from, WallTime to,
                std::size_t buckets, history::Answer& answer) {
  std::vector<SeriesName> series;
  if (const int code = find_series(session, texts, series); code != kGood) return code;
  const auto islands = keepers(session);
  if (islands.empty())
    return session.not_found("no island keeps a history",
                             "`history: {file: home.history}` in the configuration of an island begins one");
  std::map<OwnerId, std::vector<std::string>> keys;
  for (const auto& one : series) {
    const bool own = std::find(islands.begin(), islands.end(), one.owner) != islands.end();
    keys[own ? one.owner : islands.front()].push_back(to_string(one));
  }
  std::size_t number = 0;
  for (const auto& [island, some] : keys) {
    const nlohmann::ordered_json question{
        {"id", std::to_string(++number)}, {"do", "query"},     {"keys", some}, {"from", model::seconds_json(from)},
        {"to", model::seconds_json(to)},  {"buckets", buckets}};
    if (const int code = ask_one(session, island, question, answer); code != kGood) return code;
  }
  return kGood;
}

}  // namespace rubicon::cli
