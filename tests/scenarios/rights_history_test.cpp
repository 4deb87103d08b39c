#include "history/message_questions.h"
#include "model/json_members.h"
#include "scenarios/rights_of_messages.h"

namespace rubicon::scenarios {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

constexpr const char* kLampValue = "proxy.scripted-1.7.actuator.switch-1.value";

/// Answers each question with the names of its series, or with so many bytes.
struct NamingSource final : history::HistorySource {
  Handle ask(const std::string& caller, history::Question question, AnswerText text, TextCall call) override {
    asked.push_back(question);
    history::Answer answer;
    for (const auto& name : question.series) answer.series.push_back({name});
    call(bytes > 0 ? std::string(bytes, ' ') : text(answer));
    callers.push_back(caller);
    return {};
  }
  Handle series(const std::string&, Pattern, history::SeriesRange, SeriesText, TextCall) override { return {}; }
  history::HistoryCounters counters() const override { return {}; }

  std::size_t bytes = 0;
  std::vector<history::Question> asked;
  std::vector<std::string> callers;
};

class RightsOfHistory : public RightsOfMessages {
 protected:
  void begin(std::vector<rights::Rule> rules) {
    start(1, std::move(rules));
    questions = std::make_unique<history::MessageQuestions>(islands[1]->space(), islands[1]->gateway(), source);
    std::ignore = robot().declare("GATEWAY");
    replies_policy = robot().add_policy({OwnerId(kRobotId), "GATEWAY"}, [this](const tuples::RemoteSet& set) {
      const auto message = model::from_cbor(base::as_bytes(set.value));
      if (const auto* opaque = std::get_if<model::Opaque>(&message->body)) {
        EXPECT_EQ(opaque->type, history::kAnswerTag);
        replies.emplace_back(base::as_text(opaque->bytes));
      } else if (const auto* refusal = std::get_if<model::Acknowledge>(&message->body)) {
        replies.push_back(refusal->text);
      }
      return tuples::SetDecision::consumed();
    });
  }
  std::string ask(const std::string& text) {
    Message message;
    message.destination = {OwnerId(1), "", ""};
    const auto bytes = base::as_bytes(text);
    message.body = model::Opaque{std::string(history::kQuestionTag), Bytes(bytes.begin(), bytes.end())};
    post(robot(), 1, message);
    return replies.empty() ? "" : replies.back();
  }
  static std::string about(const std::string& key) {
    return R"({"id":"q1","do":"query","keys":["1:)" + key + R"("],"from":1000,"to":2000,"buckets":50})";
  }

  NamingSource source;
  std::unique_ptr<history::MessageQuestions> questions;
  Handle replies_policy;
  std::vector<std::string> replies;
};

TEST_F(RightsOfHistory, WhoMayReadATupleMayAskForItsPastWithoutTheRightToSend) {
  begin({rule("robot", {Right::kRead}, {kLampValue})});
  EXPECT_THAT(ask(about(kLampValue)), StartsWith(R"({"id":"q1","ok":true,"answer":{"from":0,)"));
  ASSERT_EQ(source.asked.size(), 1U);
  EXPECT_EQ(source.asked[0].from, model::time_from_seconds(1000));
  EXPECT_EQ(source.asked[0].buckets, 50U);
  EXPECT_EQ(source.callers[0], std::to_string(kRobotId));
}

TEST_F(RightsOfHistory, WhoMayNotReadATupleLearnsNothingOfItsPast) {
  begin({rule("robot", {Right::kRead}, {"proxy.scripted-1.7.sensor.**"}), rule("robot", {Right::kSend})});
  EXPECT_THAT(ask(about(kLampValue)), HasSubstr(std::string(R"("ok":false,"why":"robot may not read )") + kLampValue));
  EXPECT_TRUE(source.asked.empty());
  EXPECT_THAT(audit(1),
              testing::ElementsAre(testing::StartsWith("robot read " + std::string(kLampValue) + ": refused")));
}

/// The judge would see the sender that it names, and not itself, which may not read.
TEST_F(RightsOfHistory, AnIslandCannotAskInTheNameOfAnother) {
  begin({rule("maid", {Right::kRead, Right::kSend}), rule("island:2", {Right::kSend})});
  ecology.certify(OwnerId(2), support::island_member(2));
  Message message;
  message.origin = OwnerId(70200);
  message.hops = 1;
  message.sender = model::Sender{"maid"};
  message.destination = {OwnerId(1), "", ""};
  const auto text = about(kLampValue);
  const auto bytes = base::as_bytes(text);
  message.body = model::Opaque{std::string(history::kQuestionTag), Bytes(bytes.begin(), bytes.end())};
  post(component(2), 1, message);
  EXPECT_TRUE(source.asked.empty());
}

TEST_F(RightsOfHistory, OtherMessagesToTheIslandStillNeedTheRightToSend) {
  begin({rule("robot", {Right::kRead}, {kLampValue})});
  post(robot(), 1, note(1));
  EXPECT_THAT(replies.back(), HasSubstr("robot may not send to own"));
}

TEST_F(RightsOfHistory, AQuestionThatIsWrongIsAnsweredWithWhatIsWrong) {
  begin({rule("robot", {Right::kRead}, {"**"})});
  EXPECT_THAT(ask("no json"), HasSubstr(R"({"id":"","ok":false,"why":"do: expected query"})"));
  EXPECT_THAT(ask(R"({"do":"query","id":")" + std::string(65, 'x') + "\"}"),
              HasSubstr(R"({"id":"","ok":false,"why":"id: at most 64 bytes)"));
  EXPECT_THAT(ask(R"({"id":"7","do":"query","keys":[]})"), HasSubstr("0 keys, expected 1 to 32"));
  EXPECT_THAT(ask(R"({"id":"7","do":"query","keys":["a.b"],"from":1,"to":2,"buckets":1})"),
              HasSubstr("is not a series"));
  EXPECT_THAT(ask(R"({"id":"7","do":"query","keys":["1:a.b"],"from":2,"to":2,"buckets":1})"), HasSubstr("before `to`"));
  EXPECT_THAT(ask(R"({"id":"7","do":"query","keys":["1:a.b"],"from":1,"to":2,"buckets":5001})"),
              HasSubstr("buckets: expected 1 to 5000"));
  EXPECT_TRUE(source.asked.empty());
}

TEST_F(RightsOfHistory, AnAnswerThatIsTooLongForAMessageIsNamed) {
  begin({rule("robot", {Right::kRead}, {"**"})});
  source.bytes = history::MessageQuestions::kMaxAnswer + 1;
  EXPECT_THAT(ask(about(kLampValue)), HasSubstr("the answer has 200001 bytes, at most 200000 are sent"));
}

}  // namespace
}  // namespace rubicon::scenarios
