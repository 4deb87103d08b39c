#include <gmock/gmock.h>

#include "config/yaml.h"
#include "island/network_types.h"
#include "island/virtual_island.h"
#include "model/point_tuples.h"
#include "rubicon/summary.hpp"

namespace rubicon::island {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using tuples::Verdict;

constexpr const char* kHallForSettings = "{hall: {sensors: {temperature-1: {wave: constant, value: 21}}}}";

/// An island whose file is a text of the test.
class Settings : public testing::Test {
 protected:
  Settings() {
    island.settings().on_reload([this](bool try_only) { return reload(try_only); });
    everything = space.subscribe({kHome, "proxy.settings.*"}, {.passive = true}, [](const tuples::Event&) {});
    time.run_for(1s);
  }

  SettingsTuples::Outcome reload(bool try_only) {
    ++reloads;
    base::ConfigErrors errors;
    auto tree = config::parse_yaml(file, "home.yaml");
    if (!tree) return fail(tree.error());
    auto next = read_island_config(std::move(*tree), network_types(), errors);
    if (!errors.empty()) return fail(ErrorCode::kInvalid, errors.text());
    auto plan = try_only ? island.plan(next, errors) : island.reload(std::move(next), errors);
    if (!plan) return fail(plan.error());
    return plan->lines;
  }

  /// The reply to the command, and its status once it was carried out.
  tuples::Reply command(std::string_view word) {
    tuples::Reply got;
    request =
        space.set_remote(kHome, "proxy.settings.command", word, 5s, [&](const tuples::Reply& reply) { got = reply; });
    time.run_for(100ms);
    return got;
  }
  std::string value(const std::string& key) {
    const auto tuple = space.get(kHome, key);
    return tuple ? std::string(tuple->value) : "(none)";
  }
  json status() { return json::parse(value("proxy.settings.status"), nullptr, false); }

  static constexpr OwnerId kHome{6541};
  VirtualIsland home{kHallForSettings};
  VirtualScheduler& time = home.time;
  TupleSpace& space = *home.space;
  Island& island = *home.island;
  std::string file = std::string("island: {id: 6541, name: home}\nnetworks:\n  dummy-1: {type: dummy, simulate: ") +
                     kHallForSettings + "}\n";
  int reloads = 0;
  std::uint64_t request = 0;
  tuples::Handle everything;
};

TEST_F(Settings, ShowTheConfigurationInForceWithoutComments) {
  EXPECT_EQ(value("proxy.settings.value"),
            "island: {id: 6541, name: home}\n"
            "networks: {dummy-1: {type: dummy, simulate: {hall: {sensors: {temperature-1: {wave: constant, value: "
            "21}}}}}}\n");
  EXPECT_EQ(space.get(kHome, "proxy.settings.value")->media_type, "application/yaml");
  EXPECT_EQ(status()["state"], "idle");
  EXPECT_FALSE(status().contains("command"));
  const auto about = model::point_description_from_json(value("proxy.settings.description"));
  ASSERT_TRUE(about);
  EXPECT_EQ(about->data_type, "enumeration");
  ASSERT_EQ(about->words.size(), 3U);
  EXPECT_EQ(about->words[0].text, "try");
  EXPECT_EQ(about->access, "write");
}

TEST_F(Settings, TryNamesTheChangesAndChangesNothing) {
  file += "limits: {queue: 50}\n";
  EXPECT_EQ(command("try").verdict, Verdict::kApplied);
  EXPECT_EQ(status()["state"], "ok");
  EXPECT_EQ(status()["what"], "try");
  EXPECT_EQ(status()["changes"], json({"limits change"}));
  EXPECT_GT(status()["at"].get<double>(), 0);
  const auto outcome = model::command_status_from_json(value("proxy.settings.status"));
  ASSERT_TRUE(outcome);
  EXPECT_EQ(outcome->state, "confirmed");
  EXPECT_EQ(outcome->commander.creator, OwnerId(65536));
  EXPECT_EQ(outcome->commander.request, request);
  EXPECT_THAT(value("proxy.settings.value"), testing::Not(HasSubstr("limits")));
}

TEST_F(Settings, AReloadThatRecreatesNetworksAnswersItsCommand) {
  file =
      "island: {id: 6541, name: home}\nnetworks:\n"
      "  dummy-1: {type: dummy, seed: 9, simulate: {cellar: {sensors: {temperature-1: {wave: constant, value: 9}}}}}\n"
      "  dummy-2: {type: dummy, simulate: {shed: {sensors: {temperature-1: {wave: constant, value: 5}}}}}\n";
  EXPECT_EQ(command("reload").verdict, Verdict::kApplied);
  time.run_for(1s);
  EXPECT_EQ(status()["state"], "ok") << status();
  EXPECT_EQ(status()["command"]["state"], "confirmed");
  EXPECT_EQ(status()["command"]["request"], request);
  EXPECT_THAT(value("proxy.settings.value"), HasSubstr("cellar"));
  EXPECT_EQ(island.networks().ids().size(), 2U);
  EXPECT_EQ(command("reload").verdict, Verdict::kApplied);
  EXPECT_EQ(status()["changes"], json::array());
}

TEST_F(Settings, ARefusedReloadShowsEachErrorWithLineAndColumn) {
  const auto before = value("proxy.settings.value");
  file =
      "island: {id: 6541, name: home}\nnetworks:\n  dummy-1: {type: dummy, simulate: {hall: {sensors: {temperature-1: "
      "{wave: constant, value: cold}}}}}\n  knx-x: {type: knxx}\nlimits: {queue: 0}\n";
  EXPECT_EQ(command("reload").verdict, Verdict::kApplied);
  const auto errors = status()["errors"];
  ASSERT_EQ(errors.size(), 2U) << errors;
  EXPECT_EQ(errors[0]["file"], "home.yaml");
  EXPECT_EQ(errors[0]["line"], 5);
  EXPECT_EQ(errors[0]["column"], 17);
  EXPECT_THAT(errors[0]["text"].get<std::string>(), testing::StartsWith("limits.queue: "));
  EXPECT_EQ(errors[1]["line"], 4);
  EXPECT_EQ(status()["state"], "refused");
  EXPECT_EQ(status()["command"]["state"], "refused");
  EXPECT_THAT(status()["command"]["reason"].get<std::string>(), HasSubstr("and 1 more"));
  EXPECT_EQ(value("proxy.settings.value"), before);

  file =
      "island: {id: 6541, name: home}\nnetworks:\n  dummy-1:\n    type: dummy\n    simulate:\n      hall: {sensors: "
      "{temperature-1: {wave: constant, value: cold}}}\n";
  command("try");
  ASSERT_EQ(status()["errors"].size(), 1U) << status();
  EXPECT_EQ(status()["errors"][0]["line"], 6);
  EXPECT_EQ(status()["errors"][0]["column"], 63);

  file = "island: {id: 6541\n";
  command("try");
  ASSERT_EQ(status()["errors"].size(), 1U) << status();
  EXPECT_EQ(status()["errors"][0]["line"], 1);
  EXPECT_EQ(status()["errors"][0]["column"], 9);
}

TEST_F(Settings, WhatNeedsARestartHasItsPlaceToo) {
  file = "networks: {}\nisland:\n  id: 6541\n  name: house\ntuples: {engine: memory}\n";
  command("reload");
  const auto errors = status()["errors"];
  ASSERT_EQ(errors.size(), 2U) << errors;
  EXPECT_EQ(errors[0]["line"], 4);
  EXPECT_EQ(errors[0]["column"], 3);
  EXPECT_EQ(errors[0]["text"], "island.name: a running island cannot change this; restart it");
  EXPECT_EQ(errors[1]["line"], 5);
}

TEST_F(Settings, NamesThatWouldMakeTwoPointsOneHaveTheirPlace) {
  file =
      "island: {id: 6541, name: home}\nnetworks:\n  dummy-1:\n    type: dummy\n    simulate: {hall: {sensors: "
      "{temperature-1: {wave: constant, value: 21}, temperature-2: {wave: constant, value: 21}}}}\n";
  command("reload");
  ASSERT_EQ(status()["state"], "ok") << status();
  time.run_for(1s);
  file += "    devices:\n      hall: {sensors: {temperature-1: \"2\"}}\n";
  command("reload");
  const auto errors = status()["errors"];
  ASSERT_EQ(errors.size(), 1U) << errors;
  EXPECT_EQ(errors[0]["line"], 7);
  EXPECT_EQ(errors[0]["column"], 7);
}

TEST_F(Settings, OtherWordsAreRefusedAtOnce) {
  for (const auto* word : {"", "restart", "Reload", "reload now"}) {
    const auto reply = command(word);
    EXPECT_EQ(reply.verdict, Verdict::kRefused) << word;
    EXPECT_THAT(reply.text, HasSubstr("expected try, reload, undo"));
  }
  EXPECT_EQ(reloads, 0);
  EXPECT_EQ(status()["state"], "idle");
}

TEST_F(Settings, AProgramWithoutAFileRefuses) {
  island.settings().on_reload({});
  const auto reply = command("reload");
  EXPECT_EQ(reply.verdict, Verdict::kRefused);
  EXPECT_EQ(reply.code, ErrorCode::kUnsupported);
}

TEST_F(Settings, ManyCommandsAtOnceAreCarriedOutInOrderOrRefused) {
  std::vector<Verdict> verdicts;
  for (int i = 0; i < 30; ++i)
    space.set_remote(kHome, "proxy.settings.command", "try", 5s,
                     [&](const tuples::Reply& reply) { verdicts.push_back(reply.verdict); });
  time.run_for(1s);
  const auto applied = static_cast<int>(std::count(verdicts.begin(), verdicts.end(), Verdict::kApplied));
  EXPECT_EQ(verdicts.size(), 30U);
  EXPECT_GE(applied, static_cast<int>(CommandKey::kMaxWaitingCount));
  EXPECT_EQ(reloads, applied);
}

TEST_F(Settings, ManyErrorsAreCutAndCounted) {
  std::vector<std::string> lines(SettingsTuples::kMaxLineCount + 7, "x");
  island.settings().show_outcome(false, lines);
  time.run_for(100ms);
  EXPECT_EQ(status()["changes"].size(), SettingsTuples::kMaxLineCount + 1);
  EXPECT_EQ(status()["changes"].back(), "... and 7 more");
}

TEST_F(Settings, SecretsInErrorsAndChangesAreMasked) {
  island.settings().show_outcome(false,
                                 fail(ErrorCode::kInvalid, "a.yaml:1:2: --set broker.password=geheim : no\nuser:pw"));
  time.run_for(100ms);
  EXPECT_EQ(status()["errors"][0]["text"], "--set broker.password=**** : no");
  EXPECT_EQ(status()["errors"][1]["line"], 0);
}

}  // namespace
}  // namespace rubicon::island
