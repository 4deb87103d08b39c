#include "tuples/peis/peis_link.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tuples/component.h"

namespace rubicon::tuples::peis {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

struct LinksOfOurs : ::testing::Test, TwoComponents {};

TEST_F(LinksOfOurs, ASubscriberReceivesWhatThereIsAndEachChange) {
  Listener seen;
  ASSERT_TRUE(island->space.set("demo.temp.value", "21.5"));
  const auto subscription = robot->space.subscribe(pattern("1:demo.**"), {}, seen.call());
  time.run_for(100ms);
  EXPECT_THAT(seen.take(), ElementsAre("demo.temp.value=21.5"));
  ASSERT_TRUE(island->space.set("demo.temp.value", "22"));
  time.run_for(100ms);
  EXPECT_THAT(seen.take(), ElementsAre("demo.temp.value=22"));
}

TEST_F(LinksOfOurs, ValuesArriveByteForByte) {
  std::vector<std::string> seen;
  const auto subscription = robot->space.subscribe(pattern("1:v"), {}, [&](const Event& event) {
    seen.push_back(std::string(event.tuple.media_type) + "|" + std::string(event.tuple.value));
  });
  time.run_for(100ms);
  const std::string nul("a\0", 2), binary("\xff\0\xfe\0", 4);
  for (const auto& value : {std::string(), nul, binary, std::string("text")}) {
    for (const auto* type : {"text/plain", "application/octet-stream", ""}) {
      seen.clear();
      ASSERT_TRUE(island->space.set("v", value, {type}));
      time.run_for(100ms);
      EXPECT_THAT(seen, ElementsAre(std::string(type) + "|" + value));
    }
  }
}

TEST_F(LinksOfOurs, ARemoteSetThatArrivesTwiceCountsOnce) {
  ASSERT_TRUE(island->space.set("log", ""));
  const auto policy = island->space.add_policy(
      pattern("log"), [](const RemoteSet&) { return SetDecision::applied(); }, PolicyScope::kSetsAndAppends);
  RemoteSet set;
  set.from = kRobot;
  set.owner = kIsland;
  set.key = "log";
  set.value = "x";
  set.append = true;
  for (const auto request : {7U, 7U, 8U, 7U}) {
    set.request = request;
    ASSERT_TRUE(robot->link->remote_set(set));
    time.run_for(100ms);
  }
  EXPECT_EQ(island->space.get(kIsland, "log")->value, "xx");
}

TEST_F(LinksOfOurs, AKeyThatIsTooLongIsRefusedOnThisEngineOnly) {
  const std::string key(128, 'k');
  ASSERT_TRUE(island->space.set(key, "1")) << "the space has it";
  ASSERT_TRUE(island->space.set("short", "1"));
  Listener seen;
  const auto subscription = robot->space.subscribe(pattern("1:*"), {}, seen.call());
  time.run_for(100ms);
  EXPECT_THAT(seen.take(), ElementsAre("short=1"));
  std::vector<Reply> replies;
  robot->space.set_remote(kIsland, key, "2", 5s, [&](const Reply& reply) { replies.push_back(reply); });
  time.run_for(100ms);
  ASSERT_EQ(replies.size(), 1u);
  EXPECT_EQ(replies[0].verdict, Verdict::kRefused);
  EXPECT_EQ(replies[0].code, ErrorCode::kOutOfRange);
  EXPECT_NE(replies[0].text.find("128 characters"), std::string::npos);
}

}  // namespace
}  // namespace rubicon::tuples::peis
