#include "island.h"

namespace rubicon::proxy {
namespace {

using NetworkTuplesTest = Island;

TEST_F(NetworkTuplesTest, AnIslandShowsItselfAndItsNetworks) {
  config.island_name = "home \"A\"";
  config.networks["garden"];
  start();
  EXPECT_EQ(json("proxy.island")["id"], 6541);
  EXPECT_EQ(json("proxy.island")["name"], "home \"A\"");
  EXPECT_EQ(json("proxy.networks"), (std::vector<std::string>{"garden", "hall"}));
  EXPECT_EQ(json("proxy.hall.status")["line"], "up");
  EXPECT_EQ(json("proxy.garden.status")["line"], "connecting");
  EXPECT_EQ(text("proxy.hall.devices"), "[]");
  EXPECT_EQ(text("proxy.hall.property.line.value"), "up");
}

TEST_F(NetworkTuplesTest, ALineThatIsDownShowsItsAttemptsAndTheTimeOfTheNext) {
  start();
  EXPECT_EQ(json("proxy.hall.status")["attempts"], 1);
  EXPECT_EQ(json("proxy.hall.status")["next_attempt"], 0);
  hall().line_works = false;
  hall().lose_line();
  time.run_for(5s);
  const auto first = json("proxy.hall.status");
  EXPECT_EQ(first["line"], "down");
  EXPECT_GT(first["attempts"], 2);
  EXPECT_GE(first["next_attempt"], base::to_seconds(time.wall_now()));
  time.run_for(10s);
  const auto later = json("proxy.hall.status");
  EXPECT_GT(later["attempts"], first["attempts"]);
  EXPECT_EQ(later["since"], first["since"]) << "it has been down for as long";
  hall().line_works = true;
  time.run_for(5s);
  EXPECT_EQ(json("proxy.hall.status")["line"], "up");
  EXPECT_EQ(json("proxy.hall.status")["next_attempt"], 0);
}

TEST_F(NetworkTuplesTest, ListsTheReachableDevices) {
  start();
  join("7", lamp());
  join("1.4.6", lamp());
  auto sleeping = lamp();
  sleeping.heard = false;
  join("9", sleeping);
  time.run_for(1s);
  EXPECT_EQ(json("proxy.hall.devices"), (std::vector<std::string>{"1_4_6", "7"}));
}

TEST_F(NetworkTuplesTest, ADeviceThatLeftIsNoLongerListed) {
  start();
  join("7", lamp());
  join("8", lamp());
  time.run_for(1s);
  ASSERT_EQ(json("proxy.hall.devices"), (std::vector<std::string>{"7", "8"}));
  say("7", model::Leave{"thrown away"});
  time.run_for(1s);
  EXPECT_EQ(json("proxy.hall.devices"), (std::vector<std::string>{"8"}));
}

TEST_F(NetworkTuplesTest, ListsTheReachableDevicesOfAllNetworksInOneTuple) {
  config.networks["garden"];
  config.networks["knx-hall"];
  start();
  EXPECT_EQ(text("proxy.devices"), "[]");
  join("7", lamp());
  join("1.4.6", lamp());
  const auto from_garden = [this](model::Body body) {
    gate->from_network("garden", Message{model::kNoOwner, 0, 0, {kIsland, "garden", "pond"}, {kIsland, {}, {}}, body});
  };
  from_garden(lamp());
  time.run_for(1s);
  EXPECT_EQ(json("proxy.devices"), (std::vector<std::string>{"garden.pond", "hall.1_4_6", "hall.7"}));
  from_garden(model::Leave{"frozen"});
  time.run_for(1s);
  EXPECT_EQ(json("proxy.devices"), (std::vector<std::string>{"hall.1_4_6", "hall.7"}));
}

TEST_F(NetworkTuplesTest, PublishesTheListAtMostFourTimesASecond) {
  start();
  int lists = 0, lists_of_island = 0;
  const auto ears =
      space->subscribe({kIsland, "proxy.hall.devices"}, {.passive = true}, [&](const Event&) { ++lists; });
  const auto more_ears =
      space->subscribe({kIsland, "proxy.devices"}, {.passive = true}, [&](const Event&) { ++lists_of_island; });
  time.run_for(1s);
  lists = lists_of_island = 0;
  for (int device = 0; device < 1000; ++device) {
    join(std::to_string(device), lamp());
    time.run_for(2ms);
  }
  time.run_for(1s);
  EXPECT_GE(lists, 8);
  EXPECT_LE(lists, 10);
  EXPECT_GE(lists_of_island, 2);
  EXPECT_LE(lists_of_island, 4) << "that one at most once";
  EXPECT_EQ(json("proxy.hall.devices").size(), 1000u);
  EXPECT_EQ(json("proxy.devices").size(), 1000u);
}

TEST_F(NetworkTuplesTest, ADeviceThatJoinsAndLeavesCostsOneListOfTheIslandASecond) {
  start();
  join("7", lamp());
  time.run_for(2s);
  int lists = 0;
  const auto ears = space->subscribe({kIsland, "proxy.devices"}, {.passive = true}, [&](const Event&) { ++lists; });
  time.run_ready();
  lists = 0;
  for (int i = 0; i < 100; ++i) {
    i % 2 == 0 ? join("8", lamp()) : say("8", model::Leave{"moth"});
    time.run_for(90ms);
  }
  EXPECT_GE(lists, 4);
  EXPECT_LE(lists, 10);
  time.run_for(2s);
  EXPECT_EQ(json("proxy.devices"), (std::vector<std::string>{"hall.7"}));
}

TEST_F(NetworkTuplesTest, AListTooLongForAValueIsPublishedAsEmptyAndReportedOnce) {
  const std::string attic(60, 'a');
  config.networks[attic].silence.reset();
  start();
  const auto from_attic = [&](int device, model::Body body) {
    const auto address = std::to_string(10000 + device) + std::string(59, 'x');
    gate->from_network(attic, Message{model::kNoOwner, 0, 0, {kIsland, attic, address}, {kIsland, {}, {}}, body});
    if (device % 1000 == 0) time.run_ready();
  };
  const auto reported = [this] {
    return std::count_if(log.lines.begin(), log.lines.end(),
                         [](const auto& line) { return line.find("proxy.devices is published as []") != line.npos; });
  };
  for (int i = 0; i < 8600; ++i) from_attic(i, Join{});
  time.run_for(2s);
  EXPECT_TRUE(text("proxy.devices") == "[]");
  EXPECT_EQ(json("proxy." + attic + ".devices").size(), 8600u) << "that one fits";
  for (int i = 0; i < 70; ++i) {
    say("8", i % 2 == 0 ? model::Body(Join{}) : model::Body(model::Leave{"moth"}));
    time.run_for(1s);
  }
  EXPECT_EQ(reported(), 1);
  for (int i = 0; i < 1000; ++i) from_attic(i, model::Leave{"thrown away"});
  time.run_for(2s);
  EXPECT_EQ(json("proxy.devices").size(), 7600u);
}

TEST_F(NetworkTuplesTest, ShowsTheCountersOfTheNetwork) {
  start();
  say("", model::State{model::LineState::kUp, {}, {{"bad-frames", 3}}});
  time.run_for(1s);
  EXPECT_EQ(text("proxy.hall.property.bad-frames.value"), "3");
  say("", model::State{model::LineState::kUp, {}, {{"bad-frames", 4}}});
  time.run_for(1s);
  EXPECT_EQ(text("proxy.hall.property.bad-frames.value"), "4");
}

TEST_F(NetworkTuplesTest, ShowsWhatElseTheNetworkWantsSeen) {
  start();
  say("", model::State{model::LineState::kUp, {}, {}, {{"server", "hall router"}, {"unassigned", R"({"1/2/7":1})"}}});
  time.run_for(1s);
  EXPECT_EQ(text("proxy.hall.property.server.value"), "hall router");
  EXPECT_EQ(text("proxy.hall.property.unassigned.value"), R"({"1/2/7":1})");
}

TEST_F(NetworkTuplesTest, ShowsTheReadingsItsQueueDropped) {
  limits.queue = 10;
  start();
  join("7", lamp());
  for (int i = 0; i < 30; ++i) hall().say("7", updates(sensor(kGlow), 1.0 + i));
  time.run_for(2s);
  EXPECT_EQ(text("proxy.hall.property.dropped-readings.value"), "20");
  EXPECT_EQ(text("proxy.hall.7.sensor.glow-1.value"), "30");
}

TEST_F(NetworkTuplesTest, AnInventiveNetworkDoesNotFillTheTupleSpace) {
  start();
  model::State state{model::LineState::kUp, {}, {}};
  for (int i = 0; i < 5000; ++i) state.counters["counter-" + std::to_string(i)] = 1;
  say("", state);
  time.run_for(1s);
  int shown = 0;
  space->list({kIsland, "proxy.hall.property.**"}, [&](const tuples::TupleView&) { ++shown; });
  EXPECT_LE(shown, 256);
}

TEST_F(NetworkTuplesTest, ANetworkThatNeverSpeaksOfItsLineCountsAsUpOnceItDelivers) {
  start();
  gate->from_network("mute", Message{model::kNoOwner, 0, 0, {kIsland, "mute", "7"}, {kIsland, {}, {}}, lamp()});
  time.run_for(1s);
  EXPECT_EQ(json("proxy.mute.status")["line"], "up");
  EXPECT_EQ(json("proxy.networks"), (std::vector<std::string>{"hall", "mute"}));
}

}  // namespace
}  // namespace rubicon::proxy
