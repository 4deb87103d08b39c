#include "scenarios/rights_of_messages.h"

#include <array>

namespace rubicon::scenarios {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST_F(RightsOfMessages, AMessageCannotCommandWhatASetMayNot) {
  start(1, {rule("robot", {Right::kSend})});
  EXPECT_EQ(post(robot(), 1, switch_on(1)).verdict, Verdict::kApplied);
  EXPECT_EQ(commands(1), 0U);
  EXPECT_THAT(audit(1), ElementsAre("robot set " + std::string(kLampCommand) + ": refused"));
  EXPECT_THAT(audits[1]->hosts, ElementsAre("memory")) << "as its engine knows it, not as its summary says";
}

TEST_F(RightsOfMessages, WhoMaySetTheTupleMayCommandByMessageWithoutTheRightToSend) {
  start(1, {rule("robot", {Right::kSet}, {kLampCommand})});
  post(robot(), 1, switch_on(1));
  EXPECT_EQ(commands(1), 1U);
  EXPECT_THAT(audit(1), ElementsAre("robot set " + std::string(kLampCommand) + ": accepted"));
}

TEST_F(RightsOfMessages, ARefusalIsAnsweredWithItsReason) {
  start(1, {});
  const auto policy = hear_answers();
  post(robot(), 1, switch_on(1));
  post(robot(), 1, note(1, "scripted-1", "7"));
  post(robot(), 1, note(1));
  post(robot(), 1, note(2));
  ASSERT_EQ(answers.size(), 4U);
  EXPECT_THAT(answers[0], HasSubstr("robot may not set scripted-1.7"));
  EXPECT_THAT(answers[1], HasSubstr("robot may not send to scripted-1.7"));
  EXPECT_THAT(answers[2], HasSubstr("robot may not send to own"));
  EXPECT_THAT(answers[3], HasSubstr("robot may not send to island:2"));
  EXPECT_EQ(islands[1]->gateway().counters().not_permitted, 3U);
}

TEST_F(RightsOfMessages, ADeviceIsDeniedByItsAddressAndByItsIdAndAllowedByEither) {
  start(1,
        {rule("robot", {Right::kSend}, {"scripted-1.*"}, {"scripted-1.kitchen", "scripted-1.9"}),
         rule("maid", {Right::kSend}, {"scripted-1.kitchen", "scripted-1.9"})},
        "devices: {8: {id: kitchen}, 9: {id: hall}}");
  for (const auto* device : {"8", "9"}) devices_of(1).say(device, lamp());
  for (const auto* device : {"7", "8", "9"}) post(robot(), 1, note(1, "scripted-1", device));
  for (const auto* device : {"7", "8", "9"}) post(member(70200, "maid"), 1, note(1, "", device));
  EXPECT_THAT(audit(1), ElementsAre("robot send scripted-1.7: accepted", "robot send scripted-1.8: refused",
                                    "robot send scripted-1.9: refused", "maid send scripted-1.7: refused",
                                    "maid send scripted-1.8: accepted", "maid send scripted-1.9: accepted"));
}

TEST_F(RightsOfMessages, WhoMayNothingIsNotToldWhichNetworksDevicesAndPointsThereAre) {
  start(1, {});
  const auto policy = hear_answers();
  const auto commands_to = [&](const std::string& network, const std::string& device, const char* type) {
    auto message = switch_on(1);
    message.destination = {OwnerId(1), network, device};
    message.body = model::Actuate{1, actuator(type), true};
    post(robot(), 1, message);
    return std::exchange(answers, {});
  };
  EXPECT_THAT(commands_to("scripted-1", "7", "switch"),
              ElementsAre("robot may not set scripted-1.7 from 1/scripted-1/7"));
  EXPECT_THAT(commands_to("scripted-1", "7", "dimmer"),
              ElementsAre("robot may not set scripted-1.7 from 1/scripted-1/7"));
  EXPECT_THAT(commands_to("scripted-1", "8", "switch"),
              ElementsAre("robot may not set scripted-1.8 from 1/scripted-1/8"));
  EXPECT_THAT(commands_to("nowhere", "7", "switch"), ElementsAre("robot may not set nowhere.7 from 1/nowhere/7"));
  const auto there = commands_to("", "7", "switch"), not_there = commands_to("", "8", "switch");
  EXPECT_THAT(there, ElementsAre("robot may not send to own: no rule allows it from 1/7"));
  EXPECT_THAT(not_there, ElementsAre("robot may not send to own: no rule allows it from 1/8"));
  post(robot(), 1, note(1, "", "7"));
  EXPECT_EQ(answers, there);
}

TEST_F(RightsOfMessages, OfSeveralNetworksWithADeviceItsSenderIsToldOfThoseThatItMaySendTo) {
  start(1,
        {rule("maid", {Right::kSend}, {"scripted-2.*"}),
         rule("gardener", {Right::kSend}, {"scripted-1.7", "scripted-2.7"})},
        kSecondNetwork);
  ScriptedNetwork::of(1, "scripted-2").say("7", lamp());
  scheduler.run_ready();
  const auto policy = hear_answers();
  post(robot(), 1, note(1, "", "7"));
  EXPECT_THAT(answers, ElementsAre("robot may not send to own: no rule allows it from 1/7"));
  post(member(70200, "maid"), 1, note(1, "", "7"));
  EXPECT_EQ(ScriptedNetwork::of(1, "scripted-2").sent.size(), 1U);
  post(member(70300, "gardener"), 1, note(1, "", "7"));
  EXPECT_THAT(audit(1), ElementsAre("robot send scripted-1.7: refused", "maid send scripted-2.7: accepted",
                                    "gardener send own: refused"));
  EXPECT_THAT(audits[1]->whys.back(), HasSubstr("is in 2 networks of island 1 (scripted-1, scripted-2): name one"));
  EXPECT_EQ(judges[1]->refused(), 1U) << "the answer to the robot, and no network that was left out";
}

TEST_F(RightsOfMessages, OfSeveralNetworksWithADeviceACommanderIsToldOfThoseThatItMayCommand) {
  start(1,
        {rule("maid", {Right::kSet}, {"proxy.scripted-2.**"}), rule("gardener", {Right::kSet}, {"proxy.scripted-*.**"}),
         rule("sender", {Right::kSend})},
        kSecondNetwork);
  ScriptedNetwork::of(1, "scripted-2").say("7", lamp());
  scheduler.run_ready();
  const auto policy = hear_answers();
  auto message = switch_on(1);
  message.destination.network.clear();
  post(robot(), 1, message);
  post(member(70200, "maid"), 1, message);
  post(member(70300, "gardener"), 1, message);
  post(member(70400, "sender"), 1, message);
  EXPECT_THAT(answers, ElementsAre("robot may not send to own: no rule allows it from 1/7"));
  EXPECT_EQ(commands(1), 0U);
  EXPECT_EQ(ScriptedNetwork::of(1, "scripted-2").commands.size(), 1U);
  EXPECT_THAT(audit(1),
              ElementsAre("robot set " + std::string(kLampCommand) + ": refused",
                          "maid set proxy.scripted-2.7.actuator.switch-1.command: accepted",
                          "gardener send own: refused", "sender set " + std::string(kLampCommand) + ": refused"));
  EXPECT_THAT(audits[1]->whys[2], HasSubstr("is in 2 networks of island 1 (scripted-1, scripted-2): name one"));
  EXPECT_EQ(judges[1]->refused(), 2U) << "of the robot and the sender";
}

TEST_F(RightsOfMessages, WhoMayReadOfADeviceIsToldWhyItIsNotCommanded) {
  start(1, {rule("robot", {Right::kRead}, {"proxy.scripted-1.*.description"})});
  const auto policy = hear_answers();
  post(robot(), 1, switch_on(1));
  auto message = switch_on(1);
  message.destination.device = "8";
  post(robot(), 1, message);
  EXPECT_THAT(answers, ElementsAre(HasSubstr("robot may not set " + std::string(kLampCommand) + ": no rule allows it"),
                                   HasSubstr("scripted-1 has no device '8'")));
}

TEST_F(RightsOfMessages, MessagesToADeviceNeedTheRightToSendThere) {
  start(1, {rule("robot", {Right::kSend}, {"scripted-1.7"})});
  post(robot(), 1, note(1, "scripted-1", "7"));
  post(robot(), 1, note(1, "scripted-1", "8"));
  post(robot(), 1, note(1, "", "7"));  // the network is found by the device
  ASSERT_EQ(devices_of(1).sent.size(), 2U);
  EXPECT_EQ(devices_of(1).sent[1].destination.device, "7");
  EXPECT_THAT(audit(1), ElementsAre("robot send scripted-1.7: accepted", "robot send scripted-1.8: refused",
                                    "robot send scripted-1.7: accepted"));
}

TEST_F(RightsOfMessages, ANetworkAsAWholeTakesNoneFromWhoMayNotSendToEachOfItsDevices) {
  start(1, {rule("robot", {Right::kSend}, {"scripted-1.**"}, {"scripted-1.7"}),
            rule("maid", {Right::kSend}, {"scripted-1.**"})});
  post(robot(), 1, note(1, "scripted-1"));
  EXPECT_THAT(devices_of(1).sent, IsEmpty());
  post(robot(), 1, note(1, "scripted-1", "8"));
  post(member(70200, "maid"), 1, note(1, "scripted-1"));
  EXPECT_EQ(devices_of(1).sent.size(), 2U);
  EXPECT_THAT(audit(1), ElementsAre("robot send scripted-1: refused", "robot send scripted-1.8: accepted",
                                    "maid send scripted-1: accepted"));
}

TEST_F(RightsOfMessages, TheAuditSaysWhatARequestOfAToolDoesAndWhere) {
  start(1, {rule("robot", {Right::kSend})});
  for (const std::string_view bytes :
       {R"({"id": "1", "do": "write", "address": "1/4/6", "value": "on"})", R"({"do": "read", "address": 7})",
        R"({"text": "hi"})", R"({"do": {"do": "x"}, "address": ["x"]})", "\xff{"}) {
    auto message = note(1, "scripted-1");
    message.body = model::Opaque{"knx.request", Bytes(base::as_bytes(bytes).begin(), base::as_bytes(bytes).end())};
    post(robot(), 1, message);
  }
  post(robot(), 1, note(1, "scripted-1"));
  EXPECT_THAT(audits[1]->values, ElementsAre("knx.request write 1/4/6", "knx.request read 7", "knx.request",
                                             "knx.request", "knx.request", "note"));
}

TEST_F(RightsOfMessages, TheAuditReadsNoOtherMessagesAndNoLongOnes) {
  start(1, {rule("robot", {Right::kSend})});
  const auto ask = [&](const char* type, std::size_t padding) {
    const auto text = R"({"do": "write"})" + std::string(padding, ' ');
    auto message = note(1, "scripted-1");
    message.body = model::Opaque{type, {text.begin(), text.end()}};
    post(robot(), 1, message);
  };
  ask("zigbee.admin", 65536 - 15);
  ask("zigbee.admin", 65536 - 14);
  ask("letter", 0);
  EXPECT_THAT(audits[1]->values, ElementsAre("zigbee.admin write", "zigbee.admin", "letter"));
}

TEST_F(RightsOfMessages, WhatCannotBeDeliveredIsNotAccepted) {
  start(1, {rule("robot", {Right::kSend})});
  post(robot(), 1, note(1));
  post(robot(), 1, note(1, "nowhere", "7"));
  EXPECT_THAT(audit(1), ElementsAre("robot send own: refused", "robot send nowhere.7: refused"));
  EXPECT_THAT(audits[1]->whys, ElementsAre(HasSubstr("has no listener for 'note'"), HasSubstr("no network nowhere")));
}

TEST_F(RightsOfMessages, ARelayedCommandIsJudgedByItsFirstSender) {
  start(1, {rule("robot", {Right::kSend}, {"island:2"}), rule("maid", {Right::kSend}, {"island:2"})});
  start(2, {rule("maid", {Right::kSet}, {kLampCommand}), rule("island:1", {Right::kSend}, {"scripted-1.7"})});
  post(robot(), 1, switch_on(2));
  EXPECT_EQ(commands(2), 0U);
  post(member(70200, "maid"), 1, switch_on(2));
  EXPECT_EQ(commands(2), 1U);
  EXPECT_THAT(audit(1), ElementsAre("robot send island:2: accepted", "maid send island:2: accepted"));
  EXPECT_THAT(audit(2), ElementsAre("robot set " + std::string(kLampCommand) + ": refused",
                                    "maid set " + std::string(kLampCommand) + ": accepted"));
  EXPECT_THAT(audits[2]->throughs, ElementsAre("island-1", "island-1"));
  EXPECT_THAT(audits[2]->hosts, ElementsAre("", "")) << "island 1 says who sent it, and not from where";
  EXPECT_THAT(audits[1]->hosts, ElementsAre("memory", "memory"));
}

TEST_F(RightsOfMessages, WhatIsNotHandedOnIsNotAccepted) {
  start(1, {rule("robot", {Right::kSend}, {"island:2"})}, "}\nlimits: {queue: 100");
  post(robot(), 1, note(2));
  start(2, {});
  for (int i = 0; i < 100; ++i) islands[1]->gateway().send(note(2));
  post(robot(), 1, note(2));
  post(robot(), 1, note(2));
  EXPECT_THAT(audit(1), ElementsAre("robot send island:2: refused", "robot send island:2: refused",
                                    "robot send island:2: accepted"));
  EXPECT_THAT(audits[1]->whys, ElementsAre("island 2 is not there", HasSubstr("are under way"), ""));
}

TEST_F(RightsOfMessages, AnIslandRelaysOnlyForWhoMaySendToTheOther) {
  start(1, {rule("robot", {Right::kSend}, {"island:3"})});
  start(2, {rule("robot", {Right::kSet})});
  post(robot(), 1, switch_on(2));
  EXPECT_EQ(commands(2), 0U);
  EXPECT_THAT(audit(1), ElementsAre("robot send island:2: refused"));
  EXPECT_THAT(audit(2), IsEmpty());
}

TEST_F(RightsOfMessages, AnAnswerIsHandedOnWithoutAnyRight) {
  start(1, {});
  start(2, {});
  std::vector<std::string> heard;
  const auto handle = islands[2]->gateway().subscribe(MessageKind::kAcknowledge, [&](const Message& message) {
    heard.push_back(std::get<model::Acknowledge>(message.body).text);
  });
  Message answer;
  answer.destination = {OwnerId(2), {}, {}};
  answer.body = model::Acknowledge{7, model::Outcome::kSent, "it is open"};
  EXPECT_EQ(post(robot(), 1, answer).verdict, Verdict::kApplied);
  EXPECT_THAT(heard, ElementsAre("it is open"));
  EXPECT_THAT(audit(1), IsEmpty());
}

TEST_F(RightsOfMessages, ASenderThatNamesAnotherIsJudgedByItsOwnName) {
  start(1, {rule("maid", {Right::kSet, Right::kSend})});
  auto message = switch_on(1);
  message.sender = model::Sender{"maid"};
  post(robot(), 1, message);
  EXPECT_EQ(commands(1), 0U);
  EXPECT_THAT(audit(1), ElementsAre("robot set " + std::string(kLampCommand) + ": refused"));
}

TEST_F(RightsOfMessages, OnlyTheIslandOfACertificateRelays) {
  start(1, {rule("maid", {Right::kSet})});
  auto message = switch_on(1);
  message.origin = OwnerId(70200);
  message.hops = 1;
  message.sender = model::Sender{"maid"};
  EXPECT_EQ(post(robot(), 1, message).verdict, Verdict::kRefused);
  ecology.certify(OwnerId(9), support::tool_member("mallory", 70300));  // it took the id of an island
  EXPECT_EQ(post(component(9), 1, message).verdict, Verdict::kRefused);
  EXPECT_EQ(commands(1), 0U);
  EXPECT_THAT(audit(1), ElementsAre("robot send GATEWAY: refused", "mallory send GATEWAY: refused"));
}

/// An island's certificate makes no administrator: what it says of others counts where it may send itself.
TEST_F(RightsOfMessages, AnIslandWithoutTheRightToSendIsNotBelievedAboutSenders) {
  start(1, {rule("admin", {Right::kSet, Right::kSend}), rule("island:2", {Right::kSend}, {"scripted-1.8", "own"})});
  ecology.certify(OwnerId(2), support::island_member(2));
  auto& liar = component(2);
  for (auto message : {switch_on(1), note(1, "scripted-1", "7"), note(1, "", "7"), note(3)}) {
    message.origin = OwnerId(70200);
    message.hops = 1;
    message.sender = model::Sender{"maid", {"admin"}};
    post(liar, 1, message);
  }
  EXPECT_EQ(commands(1), 0U);
  EXPECT_THAT(devices_of(1).sent, IsEmpty());
  EXPECT_EQ(islands[1]->gateway().counters().not_permitted, 4U);
  EXPECT_THAT(audit(1), ElementsAre("island-2 send scripted-1.7: refused", "island-2 send scripted-1.7: refused",
                                    "island-2 send scripted-1.7: refused", "island-2 send island:3: refused"));
}

TEST_F(RightsOfMessages, WhatIsRefusedDoesNotUseUpTheNumbersOfOthers) {
  start(1, {rule("island:3", {Right::kSend}, {"scripted-1.7"}), rule("island:3", {Right::kSet}, {kLampCommand})});
  for (const std::uint32_t id : {2U, 3U}) ecology.certify(OwnerId(id), support::island_member(id));
  auto genuine = std::array{note(1, "scripted-1", "7"), switch_on(1)};
  for (std::size_t i = 0; i < genuine.size(); ++i) {
    genuine[i].origin = OwnerId(3);
    genuine[i].number = 100 + i;
  }
  for (auto message : genuine) {
    message.hops = 1;
    post(component(2), 1, message);
    message.sender = model::Sender{"admin"};
    post(component(2), 1, message);
    message.body = model::Acknowledge{7, model::Outcome::kSent, ""};
    post(component(2), 1, message);
    message.destination = {OwnerId(1), "scripted-1", "no such device"};
    message.body = model::Actuate{1, actuator("switch"), true};
    message.sender.reset();
    post(component(2), 1, message);
  }
  EXPECT_THAT(devices_of(1).sent, IsEmpty());
  for (const auto& message : genuine) post(component(3), 1, message);
  EXPECT_EQ(devices_of(1).sent.size(), 2U);
  for (const auto& message : genuine) post(component(3), 1, message);
  EXPECT_EQ(devices_of(1).sent.size(), 2U) << "of those that were let in, later ones are repeated";
  EXPECT_EQ(islands[1]->gateway().counters().duplicates, 2U);
}

/// Island 2 may relay to device 8 only, island 4 to device 7 too.
TEST_F(RightsOfMessages, WhatIsRelayedToOnePlaceDoesNotUseUpTheNumbersOfOthersForAnother) {
  start(1, {rule("island:2", {Right::kSend}, {"scripted-1.8"}), rule("island:4", {Right::kSend}, {"scripted-1.*"}),
            rule("island:3", {Right::kSend}, {"scripted-1.*"}), rule("island:3", {Right::kSet}, {kLampCommand})});
  for (const std::uint32_t id : {2U, 3U, 4U}) ecology.certify(OwnerId(id), support::island_member(id));
  auto message = note(1, "scripted-1", "7"), command = switch_on(1);
  message.number = 100;
  command.number = 101;
  const auto relay_by = [&](std::uint32_t island, Message one, const std::string& device) {
    one.hops = 1;
    one.destination.device = device;
    one.sender = model::Sender{"island-3", {}, OwnerId(3)};
    post(component(island), 1, one);
  };
  for (auto* genuine : {&message, &command}) {
    genuine->origin = OwnerId(3);
    auto forged = note(1, "scripted-1", "8");
    forged.origin = OwnerId(3);
    forged.number = genuine->number;
    relay_by(2, forged, "8");
  }
  EXPECT_EQ(devices_of(1).sent.size(), 2U);
  post(component(3), 1, message);
  relay_by(4, command, "7");
  EXPECT_EQ(devices_of(1).sent.size(), 4U);
  relay_by(4, message, "7");
  post(component(3), 1, command);
  EXPECT_EQ(devices_of(1).sent.size(), 4U) << "each arrives once by two ways, whichever is first";
  EXPECT_EQ(islands[1]->gateway().counters().duplicates, 2U);
}

TEST_F(RightsOfMessages, AMemberWithMoreRolesThanAMessageNamesSendsNothingToOtherIslands) {
  start(1, {rule("robot", {Right::kSend})});
  start(2, {rule("island:1", {Right::kSend}), rule("robot", {Right::kSend})});
  auto many = support::tool_member("robot", kRobotId);
  for (std::size_t i = 0; i <= model::kMaxRoles; ++i) many.roles.push_back("role" + std::to_string(i));
  ecology.certify(OwnerId(kRobotId), many);
  post(component(kRobotId), 1, note(2, "scripted-1", "7"));
  EXPECT_THAT(devices_of(2).sent, IsEmpty());
  EXPECT_THAT(audits[1]->whys, ElementsAre(HasSubstr("expected at most 32")));
}

TEST_F(RightsOfMessages, AnIslandSpeaksForItselfWithoutASender) {
  start(1, {});
  start(2, {rule("island:1", {Right::kSend}, {"scripted-1.7"})});
  auto message = note(2, "scripted-1", "7");
  message.source.device = "3";
  devices_of(1).host().deliver(std::move(message));
  scheduler.run_for(1s);
  EXPECT_EQ(devices_of(2).sent.size(), 1U);
  EXPECT_THAT(audit(1), IsEmpty());
  EXPECT_THAT(audit(2), ElementsAre("island-1 send scripted-1.7: accepted"));
}

TEST_F(RightsOfMessages, AMessageForThreeIslandsKeepsItsSender) {
  start(1, {rule("robot", {Right::kSend}, {"own"})});
  start(2, {rule("robot", {Right::kSend}, {"own", "island:3"})});
  start(3, {rule("robot", {Right::kSend}, {"own"}), rule("island:2", {Right::kSend})});
  std::vector<Handle> listeners;
  std::vector<std::string> names;
  for (std::uint32_t id = 1; id <= 3; ++id) {
    auto& gateway = islands[id]->gateway();
    listeners.push_back(gateway.subscribe_user("note", [&, id](const Message& message) {
      names.push_back(std::to_string(id) + " " + message.sender->name);
      auto onward = message;
      onward.destination.island = OwnerId(id % 3 + 1);
      gateway.send(std::move(onward));
    }));
  }
  post(robot(), 2, note(2));
  EXPECT_THAT(names, ElementsAre("2 robot", "3 robot"));
  EXPECT_THAT(audit(3), ElementsAre("robot send own: accepted", "robot send island:1: refused"));
}

TEST_F(RightsOfMessages, ADeviceCommandsItsIslandAsBefore) {
  start(1, {});
  auto message = switch_on(1);
  message.source.device = "3";
  devices_of(1).host().deliver(std::move(message));
  scheduler.run_ready();
  EXPECT_EQ(commands(1), 1U);
  EXPECT_THAT(audit(1), IsEmpty());
}

TEST_F(RightsOfMessages, ADeviceRoamsOnlyToAnIslandThatItsCertificateNamesAndThatMaySetTheClaim) {
  const auto read_all = rule("everybody", {Right::kRead, Right::kDemand});
  start(1, {read_all, rule("island:4", {Right::kSet}, {"ROAMING.lab.*"})}, kLab);
  EXPECT_NE(value(islands[1]->space(), 1, "proxy.scripted-1.7.status"), "(none)");
  ecology.certify(OwnerId(2), support::tool_member("mallory", 70300));
  auto& liar = component(2);
  const std::string claim = R"({"key":"proxy.wsn-1.7","network":"wsn-1","device":"7","address":"7","since":4000000000,)"
                            R"("reachable":true})";
  ASSERT_TRUE(liar.set("ROAMING.lab.7", claim, {"application/json"}));
  scheduler.run_for(5s);
  EXPECT_NE(value(islands[1]->space(), 1, "proxy.scripted-1.7.status"), "(none)");
  start(3, {read_all}, kLab);  // announces the same device, and may not claim it here
  scheduler.run_for(5s);
  EXPECT_NE(value(islands[1]->space(), 1, "proxy.scripted-1.7.status"), "(none)");
  start(4, {read_all}, kLab);
  scheduler.run_for(5s);
  EXPECT_EQ(value(islands[1]->space(), 1, "proxy.scripted-1.7.status"), "(none)");
}

/// A command that waits for a device follows it to island 2, which may or may not take it.
class RightsOfFollowers : public RightsOfMessages {
 protected:
  void follow(std::vector<std::string> except) {
    const std::vector<std::string> claims{"ROAMING.lab.*"};
    const auto read_all = rule("everybody", {Right::kRead, Right::kDemand});
    start(1, {read_all, rule("island:2", {Right::kSet}, claims), rule("robot", {Right::kSet}, {kLampCommand})}, kLab);
    devices_of(1).cable = false;
    devices_of(1).lose_line();
    auto from_one = rule("island:1", {Right::kSet}, claims, {});
    from_one.keys.push_back("proxy.scripted-9.**");
    from_one.except = std::move(except);
    for (const auto& key : from_one.except) from_one.keys.push_back(key);
    robot().set_remote(OwnerId(1), kLampCommand, "on", 60s, nullptr);
    scheduler.run_for(1s);
    audit(1).clear();
    start(2, {read_all, from_one}, kLab);
    scheduler.run_for(5s);
  }
};

TEST_F(RightsOfFollowers, TheAuditHasTheCommandThatFollowedAndTheTakeover) {
  follow({});
  EXPECT_EQ(commands(2), 1U);
  EXPECT_THAT(audit(2), ElementsAre("island-1 set " + std::string(kLampCommand) + ": accepted"));
  EXPECT_THAT(audits[2]->values, ElementsAre("on"));
  EXPECT_THAT(audit(1), ElementsAre("island-2 set ROAMING.lab.7: accepted"));
}

TEST_F(RightsOfFollowers, AnExceptionForTheCommandItselfHolds) {
  follow({kLampCommand});
  EXPECT_EQ(commands(2), 0U);
  EXPECT_THAT(audit(2), ElementsAre("island-1 set " + std::string(kLampCommand) + ": refused"));
  EXPECT_THAT(audits[2]->quotes, ElementsAre(false));
}

TEST_F(RightsOfMessages, AClaimOfOneDeviceTakesNoOtherAway) {
  start(1, {rule("everybody", {Right::kRead}), rule("island:2", {Right::kSet}, {"ROAMING.lab.8", "ROAMING.lab.7-2"})},
        kLab);
  ecology.certify(OwnerId(2), support::island_member(2));
  const std::string claim = R"({"key":"proxy.wsn-1.7","network":"wsn-1","device":"7","address":"7","since":4000000000,)"
                            R"("reachable":true})";
  for (const auto* key : {"ROAMING.lab.8", "ROAMING.lab.7", "ROAMING.lab.7-2", "ROAMING.lab.7-x"}) {
    ASSERT_TRUE(component(2).set(key, claim, {"application/json"}));
    scheduler.run_for(5s);
    EXPECT_NE(value(islands[1]->space(), 1, "proxy.scripted-1.7.status"), "(none)") << key;
  }
}

}  // namespace
}  // namespace rubicon::scenarios
