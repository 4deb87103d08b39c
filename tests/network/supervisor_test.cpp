#include "network/supervisor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <vector>

#include "base/virtual_scheduler.h"
#include "support/collecting_log.h"
#include "support/memory/memory_transports.h"

namespace rubicon::network {
namespace {

using namespace std::chrono_literals;
using model::LineState;
using model::State;
using ::testing::ElementsAre;

/// What the tests tell networks to do, and what these did.
struct Script {
  bool opens = true;
  bool says_up = true;
  bool fails_inside_open = false;
  bool fails_inside_send = false;
  bool speaks_when_destroyed = false;
  bool has_last_words = false;
  bool makes_pauses = false;
  unsigned reopened = 0;
  std::vector<std::function<void()>> closing;
  std::vector<SteadyTime> openings;
  std::vector<Message> sent;
  NetworkHost* host = nullptr;
};
Script* script = nullptr;

class Played final : public Network {
 public:
  explicit Played(NetworkHost& host) : host_(host) { script->host = &host; }
  ~Played() override {
    if (!script->speaks_when_destroyed) return;
    host_.deliver("7", model::KeepAlive{});
    host_.failed({ErrorCode::kIo, "gone"});
  }
  Played(const Played&) = delete;
  Played& operator=(const Played&) = delete;

  Result<void> open() override {
    script->openings.push_back(host_.scheduler().now());
    if (script->fails_inside_open) host_.failed({ErrorCode::kIo, "first word"});
    if (!script->opens) return fail(ErrorCode::kIo, "no cable");
    if (script->says_up) host_.deliver({}, State{LineState::kUp, {}, {}});
    return {};
  }
  Result<void> send(const Message& message) override {
    script->sent.push_back(message);
    if (script->fails_inside_send) host_.failed({ErrorCode::kIo, "pulled"});
    return {};
  }
  Result<void> reopen() override {
    ++script->reopened;
    return script->makes_pauses ? Result<void>() : Network::reopen();
  }
  bool close(std::function<void()> closed) override {
    if (script->has_last_words) script->closing.push_back(std::move(closed));
    return script->has_last_words;
  }

 private:
  NetworkHost& host_;
};

NetworkType played(Duration longest_pause = 1s) {
  return {.name = "played",
          .summary = "",
          .sample_config = "",
          .make = [](const NetworkConfig&, NetworkHost& host) -> Result<std::unique_ptr<Network>> {
            return std::make_unique<Played>(host);
          },
          .longest_pause = longest_pause};
}

struct Sink final : MessageSink {
  void from_network(const std::string& network, Message&& message) override {
    EXPECT_EQ(network, message.source.network);
    messages.push_back(std::move(message));
  }
  std::vector<State> states() const {
    std::vector<State> all;
    for (const auto& message : messages) {
      if (const auto* state = std::get_if<State>(&message.body)) all.push_back(*state);
    }
    return all;
  }
  std::vector<Message> messages;
};

class SupervisorTest : public ::testing::Test {
 protected:
  SupervisorTest() { script = &played_; }

  Result<void> add(const std::string& id, const NetworkType& type) {
    ConfigErrors errors;
    const ConfigNode nothing;
    ConfigReader options(nothing, "networks." + id, errors);
    return supervisor.add(type, {id, IslandId{1}, options, types, {}});
  }
  std::vector<Duration> pauses() const {
    std::vector<Duration> all;
    for (std::size_t i = 1; i < played_.openings.size(); ++i)
      all.push_back(played_.openings[i] - played_.openings[i - 1]);
    return all;
  }

  Script played_;
  std::uint64_t tries_ = 0;
  VirtualScheduler time;
  transport::MemoryTransports files;
  support::CollectingLog log;
  Sink sink;
  TypeCatalogue types;
  Supervisor supervisor{IslandId{1}, time, files, log, sink};
};

TEST_F(SupervisorTest, OpensNothingBeforeTheStartAndLaterAddedNetworksAtOnce) {
  ASSERT_TRUE(add("a-1", played()));
  time.run_for(10s);
  EXPECT_TRUE(played_.openings.empty());
  supervisor.start();
  EXPECT_EQ(played_.openings.size(), 1u);
  ASSERT_TRUE(add("a-2", played()));
  EXPECT_EQ(played_.openings.size(), 2u);
  EXPECT_THAT(supervisor.ids(), ElementsAre("a-1", "a-2"));
}

struct Notebook final : NetworkMemory {
  Result<void> remember(const std::string& network, std::string_view name, ByteView value, Keep) override {
    pages[network + "/" + std::string(name)] = Bytes(value.begin(), value.end());
    return {};
  }
  Result<std::optional<Bytes>> remembered(const std::string& network, std::string_view name) override {
    return pages.at(network + "/" + std::string(name));
  }
  std::map<std::string, Bytes> pages;
};

TEST_F(SupervisorTest, KeepsWhatEachNetworkRemembersApart) {
  Notebook notebook;
  supervisor.provide_memory(notebook);
  ASSERT_TRUE(add("a-1", played()));
  ASSERT_TRUE(script->host->remember("sequence", Bytes{1}, Keep::kNow));
  ASSERT_TRUE(add("a-2", played()));
  ASSERT_TRUE(script->host->remember("sequence", Bytes{2}, Keep::kSoon));
  EXPECT_EQ(notebook.pages, (std::map<std::string, Bytes>{{"a-1/sequence", {1}}, {"a-2/sequence", {2}}}));
  EXPECT_EQ(*script->host->remembered("sequence"), Bytes{2});
}

TEST_F(SupervisorTest, HasNoMemoryUnlessItIsProvided) {
  ASSERT_TRUE(add("a-1", played()));
  EXPECT_EQ(script->host->remember("sequence", Bytes{1}, Keep::kNow).error().code, ErrorCode::kUnsupported);
  EXPECT_EQ(script->host->remembered("sequence").error().code, ErrorCode::kUnsupported);
}

TEST_F(SupervisorTest, RefusesASecondNetworkOfTheSameId) {
  ASSERT_TRUE(add("a-1", played()));
  const auto again = add("a-1", played());
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().code, ErrorCode::kDuplicate);
}

TEST_F(SupervisorTest, FillsInWhereMessagesComeFromAndGoTo) {
  ASSERT_TRUE(add("a-1", played()));
  supervisor.start();
  played_.host->deliver("7", model::KeepAlive{});
  EXPECT_EQ(sink.messages.back().source, (Address{IslandId{1}, "a-1", "7"}));
  EXPECT_EQ(sink.messages.back().destination, (Address{IslandId{1}, "", ""}));
  Message abroad;
  abroad.destination = {IslandId{2}, "b", "8"};
  abroad.body = model::Opaque{};
  played_.host->deliver(std::move(abroad));
  EXPECT_EQ(sink.messages.back().destination, (Address{IslandId{2}, "b", "8"}));
}

TEST_F(SupervisorTest, OpensALostLineAgainAfterGrowingPausesForEver) {
  ASSERT_TRUE(add("a-1", played(5s)));
  played_.opens = false;
  supervisor.start();
  time.run_for(10min);
  const auto waited = pauses();
  ASSERT_GT(waited.size(), 100u);
  Duration full = 100ms;
  for (const Duration pause : waited) {
    EXPECT_LE(pause, full);
    EXPECT_GE(pause, full * 3 / 4);
    full = std::min<Duration>(full * 2, 5s);
  }
}

TEST_F(SupervisorTest, TellsWhyTheLineIsDownAndCountsAttempts) {
  ASSERT_TRUE(add("a-1", played()));
  played_.opens = false;
  supervisor.start();
  ASSERT_EQ(sink.states().size(), 1u);
  EXPECT_EQ(sink.states()[0].line, LineState::kDown);
  EXPECT_EQ(sink.states()[0].reason, "no cable");
  const WallTime next(std::chrono::seconds(sink.states()[0].counters.at("next-attempt")));
  EXPECT_GT(next, time.wall_now());
  EXPECT_LE(next, time.wall_now() + 1s) << "100 ms, told in whole seconds";
  played_.opens = true;
  time.run_for(1s);
  EXPECT_EQ(sink.states().back().line, LineState::kUp);
  EXPECT_EQ(sink.states().back().counters.at("attempts"), 2u);
  EXPECT_EQ(sink.states().back().counters.at("next-attempt"), 0u);
}

struct Reopened : SupervisorTest {
  Result<void> reopen() {
    return supervisor.reopen(
        "a-1", [this](const Result<void>& outcome) { outcomes.push_back(outcome ? "good" : outcome.error().text); });
  }
  std::string refusal() {
    const auto tried = reopen();
    return tried ? "(tried)" : tried.error().text;
  }
  std::vector<std::string> outcomes;
};

TEST_F(Reopened, EndsThePauseBetweenTwoAttempts) {
  ASSERT_TRUE(add("a-1", played(10s)));
  played_.opens = false;
  supervisor.start();
  time.run_for(1min);
  const auto attempts = played_.openings.size();
  EXPECT_TRUE(reopen());
  EXPECT_EQ(played_.openings.size(), attempts + 1);
  EXPECT_THAT(outcomes, testing::IsEmpty()) << "in a later turn";
  time.run_ready();
  EXPECT_THAT(outcomes, ElementsAre("no cable"));
  time.run_for(100ms);
  EXPECT_EQ(played_.openings.size(), attempts + 2) << "the pauses grow from the shortest again";
  played_.opens = true;
  EXPECT_TRUE(reopen());
  time.run_for(1min);
  EXPECT_THAT(outcomes, ElementsAre("no cable", "good"));
  EXPECT_EQ(played_.openings.size(), attempts + 3);
}

TEST_F(Reopened, OnlyWhatIsNotUpAndNotBeingOpened) {
  ASSERT_TRUE(add("a-1", played()));
  EXPECT_EQ(refusal(), "the lines of the island are closed");
  supervisor.start();
  EXPECT_EQ(refusal(), "the line is up");
  played_.says_up = false;
  played_.host->failed({ErrorCode::kIo, "pulled"});
  EXPECT_TRUE(reopen());
  EXPECT_EQ(refusal(), "the line is being opened");
  played_.host->deliver({}, State{LineState::kUp, {}, {}});
  time.run_ready();
  EXPECT_THAT(outcomes, ElementsAre("good"));
  played_.host->deliver({}, State{LineState::kConnecting, {}, {}});
  EXPECT_EQ(refusal(), "the line is being opened");
  played_.host->deliver({}, State{LineState::kDown, "the peer is away", {}});
  EXPECT_EQ(refusal(), "no attempt is planned: the line waits for its peer");
  EXPECT_EQ(supervisor.reopen("b", [](const auto&) {}).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(played_.reopened, 2U);
}

TEST_F(Reopened, EndsAPauseOfTheNetworkItselfWhoseAttemptsTheReportsCount) {
  ASSERT_TRUE(add("a-1", played()));
  played_.makes_pauses = true;
  supervisor.start();
  played_.host->deliver({}, State{LineState::kRefused, "no free tunnel", {{"attempts", 3}}});
  EXPECT_TRUE(reopen());
  EXPECT_EQ(played_.reopened, 1U);
  played_.host->deliver({}, State{LineState::kRefused, "no free tunnel", {{"attempts", 3}}});
  time.run_ready();
  EXPECT_THAT(outcomes, testing::IsEmpty()) << "a report of before the attempt";
  played_.host->deliver({}, State{LineState::kConnecting, {}, {{"attempts", 4}}});
  played_.host->deliver({}, State{LineState::kRefused, "still none", {{"attempts", 4}}});
  time.run_ready();
  EXPECT_THAT(outcomes, ElementsAre("still none"));
}

TEST_F(SupervisorTest, TellsTheLogOfAFlappingLineOnceAMinuteAndReason) {
  ASSERT_TRUE(add("a-1", played()));
  ASSERT_TRUE(add("a-2", played()));
  supervisor.start();
  const auto told = [this](std::string_view part) {
    return std::count_if(log.lines.begin(), log.lines.end(),
                         [part](const auto& line) { return line.find(part) != line.npos; });
  };
  for (int i = 0; i < 1200; ++i) {
    played_.host->failed({ErrorCode::kIo, "pulled"});
    time.run_for(250ms);
  }
  EXPECT_GT(played_.openings.size(), 1000u);
  EXPECT_EQ(told("a-2: line lost: pulled"), 5);
  played_.host->failed({ErrorCode::kIo, "burnt"});
  EXPECT_EQ(told("a-2: line lost: burnt"), 1) << "another reason is news";
  EXPECT_EQ(sink.states().back().reason, "burnt");
}

TEST_F(SupervisorTest, TellsTheLogWhyALineIsNotUpWhenTheReasonChanges) {
  ASSERT_TRUE(add("a-1", played()));
  supervisor.start();
  const auto told = [this](std::string_view part) {
    return std::count_if(log.lines.begin(), log.lines.end(),
                         [part](const auto& line) { return line.find(part) != line.npos; });
  };
  EXPECT_EQ(told("line up"), 0) << "nothing was wrong";
  const auto refused = [this](const char* why) {
    played_.host->deliver({}, State{LineState::kConnecting, {}, {}});
    played_.host->deliver({}, State{LineState::kRefused, why, {{"attempts", ++tries_}}});
    time.run_for(10s);
  };
  for (int i = 0; i < 20; ++i) refused("all tunnels are in use (status 24)");
  EXPECT_EQ(told("a-1: line refused: all tunnels are in use (status 24)"), 1);
  EXPECT_EQ(sink.states().back().counters.at("attempts"), 21U) << "its own and the first";
  refused("connection type (status 22)");
  EXPECT_EQ(told("a-1: line refused: connection type"), 1);
  played_.host->deliver({}, State{LineState::kUp, {}, {}});
  EXPECT_EQ(told("a-1: line up"), 1);
  for (int i = 0; i < 30; ++i) refused(i % 2 == 0 ? "one" : "two");
  EXPECT_EQ(told("line refused: one"), 5) << "each at most once a minute";
}

TEST_F(SupervisorTest, AttemptsNeverFallWhenTheLineFails) {
  ASSERT_TRUE(add("a-1", played()));
  supervisor.start();
  played_.host->deliver({}, State{LineState::kRefused, "full", {{"attempts", 8}}});
  EXPECT_EQ(sink.states().back().counters.at("attempts"), 9U);
  played_.host->failed({ErrorCode::kIo, "pulled"});
  EXPECT_EQ(sink.states().back().counters.at("attempts"), 9U);
}

TEST_F(SupervisorTest, BeginsWithTheShortestPauseAgainOnceTheLineWasUp) {
  ASSERT_TRUE(add("a-1", played(30s)));
  played_.opens = false;
  supervisor.start();
  time.run_for(20s);
  played_.opens = true;
  time.run_for(60s);
  played_.openings = {time.now()};
  played_.host->failed({ErrorCode::kIo, "pulled"});
  time.run_for(1s);
  ASSERT_EQ(pauses().size(), 1u);
  EXPECT_LE(pauses()[0], 100ms);
}

TEST_F(SupervisorTest, RetriesOnceHoweverOftenTheNetworkFailed) {
  ASSERT_TRUE(add("a-1", played()));
  played_.fails_inside_open = true;
  played_.opens = false;
  supervisor.start();
  played_.host->failed({ErrorCode::kIo, "third word"});
  EXPECT_EQ(sink.states().size(), 1u);
  played_.fails_inside_open = false;
  played_.opens = true;
  time.run_for(10s);
  EXPECT_EQ(played_.openings.size(), 2u);
}

TEST_F(SupervisorTest, ANetworkMayFailInsideSend) {
  ASSERT_TRUE(add("a-1", played()));
  supervisor.start();
  played_.fails_inside_send = true;
  Message message;
  message.destination = {IslandId{1}, "a-1", "7"};
  EXPECT_TRUE(supervisor.send(message));
  time.run_for(1s);
  EXPECT_EQ(played_.openings.size(), 2u);
}

TEST_F(SupervisorTest, SaysThatThereIsNoSuchNetworkOrThatItIsNotOpenYet) {
  Message message;
  message.destination = {IslandId{1}, "a-1", "7"};
  EXPECT_EQ(supervisor.send(message).error().code, ErrorCode::kNotFound);
  ASSERT_TRUE(add("a-1", played()));
  EXPECT_EQ(supervisor.send(message).error().code, ErrorCode::kUnreachable);
  supervisor.start();
  EXPECT_TRUE(supervisor.send(message));
  EXPECT_EQ(played_.sent.size(), 1u);
}

TEST_F(SupervisorTest, ARemovedNetworkSaysNothingMoreAndIsReportedDown) {
  ASSERT_TRUE(add("a-1", played()));
  supervisor.start();
  played_.host->failed({ErrorCode::kIo, "pulled"});
  played_.speaks_when_destroyed = true;
  sink.messages.clear();
  supervisor.remove("a-1");
  supervisor.remove("a-1");
  ASSERT_EQ(sink.messages.size(), 1u);
  EXPECT_EQ(sink.states().at(0).line, LineState::kDown);
  EXPECT_FALSE(supervisor.has("a-1"));
  time.run_for(10s);
  EXPECT_EQ(played_.openings.size(), 1u);
}

/// What a supervisor with two networks calls when it closes.
class SupervisorEnds : public SupervisorTest {
 protected:
  void SetUp() override {
    for (const auto* id : {"a-1", "a-2"}) ASSERT_TRUE(add(id, played()));
    supervisor.start();
  }
  void close() {
    supervisor.close([this] { ++ended; });
    EXPECT_EQ(ended, 0) << "in a later turn";
  }
  int ended = 0;
};

TEST_F(SupervisorEnds, AtOnceWhereNoNetworkHasLastWords) {
  close();
  time.run_for(1ms);
  EXPECT_EQ(ended, 1);
  time.run_for(1min);
  EXPECT_EQ(ended, 1);
}

TEST_F(SupervisorEnds, WhenTheLastOneHasSpoken) {
  played_.has_last_words = true;
  close();
  ASSERT_EQ(played_.closing.size(), 2u);
  played_.closing[0]();
  time.run_for(1s);
  EXPECT_EQ(ended, 0);
  played_.closing[1]();
  time.run_for(1ms);
  EXPECT_EQ(ended, 1);
  time.run_for(1min);
  EXPECT_EQ(ended, 1);
}

TEST_F(SupervisorEnds, AfterTwoSecondsWhoeverStillSpeaks) {
  played_.has_last_words = true;
  close();
  played_.closing[0]();
  time.run_for(kClosingTime - 1ms);
  EXPECT_EQ(ended, 0);
  time.run_for(1ms);
  EXPECT_EQ(ended, 1);
}

TEST_F(SupervisorEnds, WithoutALineThatIsLostMeanwhile) {
  close();
  const auto openings = played_.openings.size();
  played_.host->failed({ErrorCode::kIo, "pulled"});
  time.run_for(1min);
  EXPECT_EQ(played_.openings.size(), openings);
}

}  // namespace
}  // namespace rubicon::network
