#include <sys/resource.h>

#include <csignal>

#include "island.h"

namespace rubicon::proxy {
namespace {

class Remembering : public Island {
 protected:
  void SetUp() override { remember(); }

  static constexpr const char* kLamp = "proxy.hall.7";
  static constexpr const char* kGlow1 = "proxy.hall.7.sensor.glow-1";

  Join lamp_with_rate() const {
    auto message = lamp();
    const auto* rate = types.find("rate");
    message.capabilities.push_back(capability(Kind::kProperty, rate->id, ""));
    return message;
  }
};

TEST_F(Remembering, AKnownDeviceIsThereAgainBeforeItSpeaks) {
  start();
  join("7", lamp());
  time.run_for(2s);
  restart();
  EXPECT_EQ(json("proxy.hall.7.description")["name"], "Lamp");
  EXPECT_EQ(json("proxy.hall.7.status")["status"], "unknown");
  EXPECT_TRUE(exists("proxy.hall.7.actuator.flap-1.command"));
  EXPECT_EQ(json("proxy.hall.devices"), nlohmann::json::array());
}

TEST_F(Remembering, TheLastValueIsPublishedAsStoredWithItsTimesUntilTheDeviceSpeaks) {
  start();
  join("7", lamp());
  const WallTime measured = time.wall_now() - 5s;
  report("7", sensor(kGlow), 12.5, measured);
  const auto heard = json(kGlow1 + std::string(".status"))["heard"].get<double>();
  time.run_for(20s);
  restart();
  time.run_ready();
  EXPECT_EQ(text(kGlow1 + std::string(".value")), "12.5");
  EXPECT_EQ(quality(kGlow1), "stored");
  EXPECT_DOUBLE_EQ(json(kGlow1 + std::string(".status"))["heard"].get<double>(), heard);
  EXPECT_EQ(space->get(kIsland, kGlow1 + std::string(".value"))->user_time, measured);
  EXPECT_EQ(quality("proxy.hall.7.sensor.glow-2"), "unknown");
  report("7", sensor(kGlow), 13.0);
  EXPECT_EQ(quality(kGlow1), "good");
  EXPECT_EQ(text(kGlow1 + std::string(".value")), "13");
}

TEST_F(Remembering, AValueOlderThanTheSavePeriodSurvivesACrash) {
  start();
  join("7", lamp());
  report("7", sensor(kGlow), 12.5);
  time.run_for(config.save_period + 1s);
  report("7", sensor(kGlow), 99.0);
  // What a killed process would leave: a second look at the file while the first process still holds it.
  std::vector<state::StoredValue> found;
  ASSERT_TRUE(store->each("hall", [&](auto, state::KnownDevice&& device) { found = device.values; }));
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(to_text(found[0].value), "12.5");
}

TEST_F(Remembering, APropertyThatAUserSetIsRememberedAndInForceAgain) {
  start();
  join("7", lamp_with_rate());
  ASSERT_EQ(set("proxy.hall.7.property.rate.command", "250").verdict, Verdict::kApplied);
  restart();
  EXPECT_EQ(text("proxy.hall.7.property.rate.value"), "250");
  join("7", lamp_with_rate());
  const auto wanted = robot->subscribe({kIsland, kGlow1 + std::string(".value")}, {}, [](const Event&) {});
  time.run_ready();
  EXPECT_EQ(hall().sampled["7"].period, 250ms);
}

TEST_F(Remembering, ACommandIsNeverExecutedAgain) {
  start();
  join("7", lamp());
  hall().answers = false;
  ASSERT_EQ(set("proxy.hall.7.actuator.flap-1.command", "open").verdict, Verdict::kApplied);
  time.run_for(30s);
  restart();
  join("7", lamp());
  report("7", actuator(kFlap), false);
  time.run_for(30s);
  EXPECT_TRUE(hall().sent_bodies<model::Actuate>().empty());
  EXPECT_EQ(text("proxy.hall.7.actuator.flap-1.command"), "");
}

TEST_F(Remembering, ADeviceThatLeftIsForgotten) {
  start();
  join("7", lamp());
  time.run_for(2s);
  say("7", model::Leave{"thrown away"});
  restart();
  EXPECT_FALSE(exists("proxy.hall.7.status"));
}

TEST_F(Remembering, AThinnerJoinDoesNotTakeNameAndModelAway) {
  start();
  join("7", lamp());
  time.run_for(2s);
  restart();
  auto thin = lamp();
  thin.name.clear();
  thin.model.clear();
  join("7", thin);
  EXPECT_EQ(json("proxy.hall.7.description")["name"], "Lamp");
  EXPECT_EQ(json("proxy.hall.7.description")["model"], "ACME L1");
}

TEST_F(Remembering, ANetworkThatListsItsDevicesShowsNoOthers) {
  rules().lists_devices = true;
  start();
  join("7", lamp());
  join("8", lamp());
  report("7", sensor(kGlow), 12.5);
  time.run_for(20s);
  restart();
  EXPECT_FALSE(exists("proxy.hall.7.status"));
  auto listed = lamp();
  listed.heard = false;
  join("7", listed);
  EXPECT_EQ(text(kGlow1 + std::string(".value")), "12.5");
  EXPECT_EQ(quality(kGlow1), "stored");
  EXPECT_FALSE(exists("proxy.hall.8.status"));
}

TEST_F(Remembering, WhatTheDeviceKnewWhenItJoinedIsNewerThanWhatIsRemembered) {
  rules().lists_devices = true;
  start();
  auto message = lamp();
  message.capabilities.push_back(capability(Kind::kProperty, kKnob, ""));
  message.capabilities.back().initial = std::int64_t{12};
  join("7", message);
  time.run_for(20s);
  restart();
  message.capabilities.back().initial = std::int64_t{15};
  join("7", message);
  EXPECT_EQ(text("proxy.hall.7.property.knob.value"), "15");
  EXPECT_EQ(quality("proxy.hall.7.property.knob"), "good");
}

TEST_F(Remembering, TheInitialValueOfASilentDeviceIsNotRemembered) {
  start();
  auto message = lamp();
  message.capabilities.push_back(capability(Kind::kProperty, kKnob, ""));
  message.capabilities.back().initial = std::int64_t{12};
  message.heard = false;
  join("7", message);
  ASSERT_EQ(quality("proxy.hall.7.property.knob"), "stored");
  time.run_for(20s);
  const auto known = *store->find("hall", "7");
  ASSERT_TRUE(known);
  EXPECT_TRUE(known->values.empty());
}

TEST_F(Remembering, AStoredValueThatNoLongerFitsItsTypeIsNotShown) {
  start();
  join("7", lamp());
  report("7", sensor(kGlow), 12.5);
  time.run_for(20s);
  ASSERT_TRUE(store->each("hall", [&](auto row, state::KnownDevice&& device) {
    device.values[0].value = std::string("bright");
    ASSERT_TRUE(store->save_values(row, device.values));
  }));
  restart();
  EXPECT_EQ(quality(kGlow1), "unknown");
  EXPECT_EQ(text(kGlow1 + std::string(".value")), "");
}

/// As older versions wrote them: enumerations and bit sets as plain numbers.
TEST_F(Remembering, AStoredNumberOfAnEnumerationIsShown) {
  start();
  Join join;
  for (const auto* type : {"enumerationInput", "bitsetInput"})
    join.capabilities.push_back(capability(Kind::kSensor, types.find(type)->id));
  say("7", join);
  report("7", join.capabilities[0].point, std::string("heat"));
  report("7", join.capabilities[1].point, model::Json{R"({"raw":5})"});
  time.run_for(20s);
  ASSERT_TRUE(store->each("hall", [&](auto row, state::KnownDevice&& device) {
    for (auto& one : device.values) one.value = std::int64_t{5};
    ASSERT_TRUE(store->save_values(row, device.values));
  }));
  restart();
  EXPECT_EQ(text("proxy.hall.7.sensor.enumerationInput-1.value"), "5");
  EXPECT_EQ(text("proxy.hall.7.sensor.bitsetInput-1.value"), "5");
  EXPECT_EQ(quality("proxy.hall.7.sensor.enumerationInput-1"), "stored");
}

TEST_F(Remembering, KeepsTheWantedKeyPart) {
  start();
  auto message = lamp();
  message.id = "window";
  join("7", message);
  time.run_for(2s);
  restart();
  EXPECT_TRUE(exists("proxy.hall.window.status"));
}

TEST_F(Remembering, ARestartDoesNotForgetWhenADeviceWasHeard) {
  start();
  join("7", lamp());
  report("7", sensor(kGlow), 12.5);
  time.run_for(20s);
  const auto heard = (*store->find("hall", "7"))->last_heard;
  ASSERT_GT(heard, WallTime{});
  restart();
  time.run_for(20s);
  EXPECT_EQ((*store->find("hall", "7"))->last_heard, heard);
}

TEST_F(Remembering, ValuesAreKeptAlsoWhenTheClockIsSetBack) {
  start();
  join("7", lamp());
  report("7", sensor(kGlow), 12.5);
  time.run_for(20s);
  time.set_wall(time.wall_now() - 1h);
  report("7", sensor(kGlow), 13.5);
  time.run_for(20s);
  restart();
  EXPECT_EQ(text(kGlow1 + std::string(".value")), "13.5");
}

TEST_F(Remembering, ADeviceTooBigForTheFileDoesNotKeepOthersOut) {
  state_options.max_bytes = 256 << 10;
  start();
  join("7", lamp());
  auto big = lamp();
  for (int i = 1; i <= 4; ++i) {
    big.capabilities.push_back(capability(Kind::kSensor, TypeId{0x9000}, std::to_string(i)));
    big.capabilities.back().type_name = "essay";
  }
  join("8", big);
  for (int i = 1; i <= 4; ++i) report("8", sensor(TypeId{0x9000}, std::to_string(i)), std::string(60000, 'x'));
  report("7", sensor(kGlow), 12.5);
  time.run_for(20s);
  restart();
  EXPECT_EQ(text(kGlow1 + std::string(".value")), "12.5");
  EXPECT_TRUE(exists("proxy.hall.8.status"));
}

/// While it exists, nothing can be written.
class FullDisk {
 public:
  FullDisk() {
    std::signal(SIGXFSZ, SIG_IGN);
    ::getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit none{0, before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &none);
  }
  ~FullDisk() { ::setrlimit(RLIMIT_FSIZE, &before_); }

 private:
  rlimit before_{};
};

TEST_F(Remembering, WhatCouldNotBeWrittenIsTriedAgain) {
  start();
  join("6", lamp());
  time.run_for(20s);
  {
    const FullDisk full;
    join("7", lamp());
    report("7", sensor(kGlow), 12.5);
    say("6", model::Leave{"thrown away"});
    time.run_for(5s);
    EXPECT_TRUE(log.contain("cannot remember"));
  }
  time.run_for(config.save_period + 20s);
  EXPECT_EQ((*store->find("hall", "6")), std::nullopt);
  const auto known = *store->find("hall", "7");
  ASSERT_TRUE(known);
  EXPECT_EQ(known->values.size(), 1U);
}

TEST_F(Remembering, ANameThatTheDiskRefusesIsRefusedAndMayBeGivenLater) {
  start();
  join("7", lamp());
  time.run_for(2s);
  Reply reply;
  {
    const FullDisk full;
    reply = set("proxy.hall.7.description", R"({"name":"Kitchen lamp"})");
  }
  EXPECT_EQ(reply.verdict, Verdict::kRefused);
  EXPECT_EQ(reply.code, ErrorCode::kIo);
  EXPECT_THAT(reply.text, ::testing::HasSubstr("proxy.hall.7 keeps its name"));
  EXPECT_EQ(json("proxy.hall.7.description")["name"], "Lamp");
  EXPECT_EQ((*store->find("hall", "7"))->given_name, "");
  time.run_for(1s);
  EXPECT_EQ(set("proxy.hall.7.description", R"({"name":"Kitchen lamp"})").verdict, Verdict::kApplied);
  EXPECT_EQ((*store->find("hall", "7"))->given_name, "Kitchen lamp");
}

TEST_F(Remembering, WhatIsNotWrittenYetIsKnownAlready) {
  config.discovery.otherwise = DiscoveryAction::kAsk;
  start();
  join("7", lamp());
  ASSERT_EQ(set("proxy.inbox.hall.7", "approve").verdict, Verdict::kApplied);
  const FullDisk full;
  say("7", model::Leave{"battery"});
  join("7", lamp());
  EXPECT_TRUE(exists("proxy.hall.7.status"));
}

TEST_F(Remembering, AGivenNameIsNotLostWhileTheDiskIsFull) {
  config.discovery.otherwise = DiscoveryAction::kAsk;
  start();
  join("7", lamp());
  ASSERT_EQ(set("proxy.inbox.hall.7", "approve").verdict, Verdict::kApplied);
  ASSERT_EQ(set("proxy.hall.7.description", R"({"name":"Kitchen lamp"})").verdict, Verdict::kApplied);
  const FullDisk full;
  say("7", model::Leave{"battery"});
  join("7", lamp());
  EXPECT_EQ(json("proxy.hall.7.description")["name"], "Kitchen lamp");
}

}  // namespace
}  // namespace rubicon::proxy
