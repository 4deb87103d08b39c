#include <gmock/gmock.h>

#include "networks/log/log_support.h"

namespace rubicon::networks::log {
namespace {

using testing::HasSubstr;

class LogNetworkTest : public testing::Test {
 protected:
  ConfigNode options(std::vector<std::pair<std::string, ConfigNode>> more = {}) {
    std::vector<std::pair<std::string, ConfigNode>> all{
        {"format", scalar("csv")},
        {"files", list({"a.csv", "b.csv"})},
        {"period", scalar("1s")},
        {"map", map({{"room", map({{"columns", map({{"t", sensor("temperature-1")}})}})}})}};
    all.insert(all.end(), more.begin(), more.end());
    return map(std::move(all));
  }

  void make(std::vector<std::pair<std::string, ConfigNode>> more = {}) {
    made_ = make_log(listener_, options(std::move(more)), types_);
    ASSERT_NE(made_.network, nullptr) << (made_.errors.empty() ? "" : made_.errors.front());
  }

  TypeCatalogue types_;
  Listener listener_;
  Made made_;
};

Message to_room(model::Body body) {
  Message message;
  message.destination = {IslandId{1}, "log-test", "room"};
  message.body = std::move(body);
  return message;
}

TEST_F(LogNetworkTest, RefusesCommandsAndSaysWhy) {
  make();
  for (const model::Body& body :
       {model::Body(model::Actuate{7, {}, true}), model::Body(model::SetProperty{7, {}, true})}) {
    const auto sent = made_.network->send(to_room(body));
    ASSERT_FALSE(sent.has_value());
    EXPECT_EQ(sent.error().code, ErrorCode::kRefused);
    EXPECT_EQ(sent.error().text, "recorded devices take no commands");
  }
}

TEST_F(LogNetworkTest, AnswersSamplingAndSaysThatOtherMessagesAreUnsupported) {
  make();
  EXPECT_TRUE(made_.network->send(to_room(model::Sample{9, {}, 1s})).has_value());
  const auto answers = listener_.of<model::Acknowledge>();
  ASSERT_EQ(answers.size(), 1u);
  const auto& answer = std::get<model::Acknowledge>(answers[0].second.body);
  EXPECT_EQ(answer.request, 9u);
  EXPECT_EQ(answer.outcome, model::Outcome::kSent);
  EXPECT_EQ(answers[0].second.source.device, "room");
  EXPECT_EQ(made_.network->send(to_room(model::Opaque{"x", {}})).error().code, ErrorCode::kUnsupported);
  EXPECT_EQ(made_.network->send(to_room(model::KeepAlive{})).error().code, ErrorCode::kUnsupported);
}

TEST_F(LogNetworkTest, AMissingFileIsNamedAndFoundWhenItComes) {
  make();
  const auto opened = made_.network->open();
  ASSERT_FALSE(opened.has_value());
  EXPECT_EQ(opened.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(opened.error().text, HasSubstr("a.csv"));
  listener_.files.files = {{"a.csv", "t\n1\n"}, {"b.csv", "t\n2\n"}};
  EXPECT_TRUE(made_.network->open().has_value());
  listener_.time.run_for(5s);
  EXPECT_EQ(listener_.readings().size(), 2u);
}

TEST_F(LogNetworkTest, AFileThatIsMissingLaterFailsTheLineAndThePlayGoesOnWithIt) {
  listener_.files.files = {{"a.csv", "t\n1\n2\n"}};
  make();
  ASSERT_TRUE(made_.network->open().has_value());
  listener_.time.run_for(5s);
  ASSERT_EQ(listener_.failures.size(), 1u);
  EXPECT_THAT(listener_.failures[0].text, HasSubstr("b.csv"));
  listener_.files.files["b.csv"] = "t\n3\n";
  ASSERT_TRUE(made_.network->open().has_value());
  listener_.time.run_for(5s);
  ASSERT_EQ(listener_.readings().size(), 3u);
  EXPECT_EQ(model::to_text(listener_.readings()[2].value), "3");
}

TEST_F(LogNetworkTest, AReadErrorFailsTheLine) {
  listener_.files.files = {{"a.csv", "t\n1\n2\n"}, {"b.csv", "t\n3\n"}};
  make();
  ASSERT_TRUE(made_.network->open().has_value());
  listener_.files.broken = true;
  listener_.time.run_for(5s);
  ASSERT_EQ(listener_.failures.size(), 1u);
  EXPECT_EQ(listener_.failures[0].code, ErrorCode::kIo);
}

TEST_F(LogNetworkTest, FilesFollowEachOtherAfterOnePeriodOrTheGapAskedFor) {
  listener_.files.files = {{"a.csv", "t\n1\n2\n"}, {"b.csv", "t\n3\n"}};
  make();
  ASSERT_TRUE(made_.network->open().has_value());
  listener_.time.run_for(10s);
  EXPECT_EQ(listener_.of<model::Updates>()[2].first, 2s);

  Listener other;
  other.files.files = listener_.files.files;
  const auto network = make_log(other, options({{"between-files", scalar("5s")}}), types_).network;
  ASSERT_TRUE(network->open().has_value());
  other.time.run_for(10s);
  EXPECT_EQ(other.of<model::Updates>()[2].first, 6s);
}

TEST_F(LogNetworkTest, TheCountersIncludeTheLastReadingBeforeAPause) {
  listener_.files.files = {{"a.csv", "t\n1\n2\n"}, {"b.csv", "t\n3\n"}};
  make({{"between-files", scalar("1h")}});
  ASSERT_TRUE(made_.network->open().has_value());
  listener_.time.run_for(10s);
  EXPECT_EQ(listener_.of<model::Updates>().size(), 2u);
  EXPECT_EQ(listener_.counter("readings"), 2u);
  const auto reports = listener_.of<model::State>().size();
  listener_.time.run_for(10min);
  EXPECT_LE(listener_.of<model::State>().size(), reports + 600) << "the position, once a second";
  EXPECT_EQ(listener_.counter("readings"), 2u);
}

TEST_F(LogNetworkTest, ALostLineReportsNoCounters) {
  listener_.files.files = {{"a.csv", "t\n1\n2\n"}, {"b.csv", "t\n3\n"}};
  make();
  ASSERT_TRUE(made_.network->open().has_value());
  listener_.time.run_for(500ms);
  listener_.files.broken = true;
  listener_.time.run_for(5s);
  ASSERT_EQ(listener_.failures.size(), 1u);
  const auto reports = listener_.of<model::State>().size();
  listener_.time.run_for(1min);
  EXPECT_EQ(listener_.of<model::State>().size(), reports);
}

TEST_F(LogNetworkTest, TheEndIsReportedAndTheDevicesStay) {
  listener_.files.files = {{"a.csv", "t\n1\n"}, {"b.csv", "t\n3\n"}};
  make();
  ASSERT_TRUE(made_.network->open().has_value());
  listener_.time.run_for(10s);
  EXPECT_EQ(listener_.last_state().line, model::LineState::kEnded);
  EXPECT_TRUE(listener_.of<model::Leave>().empty());
}

TEST_F(LogNetworkTest, DevicesLeaveAtTheEndOnRequest) {
  listener_.files.files = {{"a.csv", "t\n1\n"}, {"b.csv", "t\n3\n"}};
  make({{"end", scalar("leave")}});
  ASSERT_TRUE(made_.network->open().has_value());
  listener_.time.run_for(10s);
  const auto leaves = listener_.of<model::Leave>();
  ASSERT_EQ(leaves.size(), 1u);
  EXPECT_EQ(leaves[0].second.source.device, "room");
  EXPECT_EQ(listener_.last_state().line, model::LineState::kEnded);
}

TEST_F(LogNetworkTest, TheLineGoesDownAtTheEndOnRequest) {
  listener_.files.files = {{"a.csv", "t\n1\n"}, {"b.csv", "t\n3\n"}};
  make({{"end", scalar("stop")}});
  ASSERT_TRUE(made_.network->open().has_value());
  listener_.time.run_for(10s);
  EXPECT_EQ(listener_.last_state().line, model::LineState::kDown);
  EXPECT_EQ(listener_.last_state().reason, "the recording ended");
}

TEST_F(LogNetworkTest, ALoopPlaysAgainAndCountsItsRounds) {
  listener_.files.files = {{"a.csv", "t\n1\n"}, {"b.csv", "t\n3\n"}};
  make({{"loop", scalar("yes")}});
  ASSERT_TRUE(made_.network->open().has_value());
  listener_.time.run_for(10s);
  EXPECT_GE(listener_.readings().size(), 10u);
  EXPECT_GE(listener_.counter("rounds"), 4u);
  EXPECT_EQ(listener_.last_state().line, model::LineState::kUp);
  EXPECT_EQ(listener_.of<model::Join>().size(), 1u);
}

TEST_F(LogNetworkTest, ALoopAsFastAsPossibleStillLetsTimePass) {
  listener_.files.files = {{"a.csv", "t\n1\n"}, {"b.csv", "t\n3\n"}};
  make({{"loop", scalar("yes")}, {"speed", scalar("max")}});
  ASSERT_TRUE(made_.network->open().has_value());
  listener_.time.run_for(100ms);
  EXPECT_GE(listener_.counter("rounds"), 90u);
}

TEST_F(LogNetworkTest, DestroyedInTheMiddleItIsSilent) {
  listener_.files.files = {{"a.csv", "t\n1\n2\n"}, {"b.csv", "t\n3\n"}};
  make();
  ASSERT_TRUE(made_.network->open().has_value());
  listener_.time.run_for(0s);
  const std::size_t heard = listener_.heard.size();
  made_.network.reset();
  listener_.time.run_for(10s);
  EXPECT_EQ(listener_.heard.size(), heard);
}

TEST_F(LogNetworkTest, NamesEverythingThatIsWrongWithItsOptions) {
  const auto wrong = make_log(
      listener_,
      map({{"format", scalar("csv")},
           {"speed", scalar("-1")},
           {"end", scalar("never")},
           {"header", scalar("perhaps")},
           {"start-time", scalar("noon")},
           {"map", map({{"room", map({{"columns", map({{"t", sensor("warmth-1")}, {"h", sensor("humidity")}})},
                                      {"properties", map({{"label", map({{"value", scalar("a")},
                                                                         {"from-comment", scalar("b")}})}})}})}})}}),
      types_);
  EXPECT_EQ(wrong.network, nullptr);
  std::string all;
  for (const std::string& line : wrong.errors) all += line + "\n";
  for (const char* part : {"file: missing", "speed: '-1', expected max or a factor", "end: ", "header: `perhaps`",
                           "period: missing", "start-time: `noon`", "unknown type 'warmth'",
                           "`humidity`, expected type and instance, for example `humidity-1`",
                           "expected exactly one of value, from-comment, from-table"})
    EXPECT_THAT(all, HasSubstr(part));
}

TEST_F(LogNetworkTest, RefusesCsvKeysForPackets) {
  const auto made = make_log(
      listener_, map({{"format", scalar("packets")}, {"file", scalar("a.bin")}, {"period", scalar("1s")}}), types_);
  EXPECT_EQ(made.network, nullptr);
  ASSERT_EQ(made.errors.size(), 1u);
  EXPECT_THAT(made.errors[0], HasSubstr("period"));
}

TEST_F(LogNetworkTest, PlaysTheFlatOfTheExamples) {
  const std::string folder = RUBICON_SOURCE_DIR "/examples/recordings/";
  made_ = make_log(listener_,
                   map({{"format", scalar("csv")},
                        {"file", scalar("flat_day.csv")},
                        {"comment", scalar("#")},
                        {"time", map({{"column", scalar("time")}, {"unit", scalar("iso")}})},
                        {"map", map({{"fridge", map({{"columns", map({{"fridge_power", sensor("power-1")},
                                                                      {"fridge_door", sensor("contact-door")}})}})},
                                     {"kitchen", map({{"columns", map({{"kitchen_co2", sensor("co2-1")}})}})}})}}),
                   types_, folder);
  ASSERT_NE(made_.network, nullptr);
  ASSERT_TRUE(made_.network->open().has_value());
  listener_.time.run_for(8min);
  EXPECT_EQ(listener_.counter("damaged"), 0u);
  EXPECT_EQ(listener_.counter("records"), 480u);
  EXPECT_EQ(listener_.of<model::Join>().size(), 2u);
}

}  // namespace
}  // namespace rubicon::networks::log
