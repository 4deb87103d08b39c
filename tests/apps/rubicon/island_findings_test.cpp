#include "apps/rubicon/doctor/island_findings.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>

#include "model/findings.h"

namespace rubicon::cli {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::IsEmpty;
using Grade = Finding::Grade;

constexpr WallTime kNow{std::chrono::seconds(1'767'225'600)};

client::Network network(const std::string& line, const std::string& reason = "") {
  client::Network one;
  one.island = OwnerId(6541);
  one.prefix = "proxy";
  one.id = "knx-hall";
  one.line = {line, reason, kNow - 5min, 12, kNow + 20s};
  one.devices = one.reachable = 3;
  return one;
}

IslandSeen island() {
  IslandSeen seen;
  seen.island.id = OwnerId(6541);
  seen.island.summary.name = "home";
  seen.island.summary.host = "attic";
  seen.answers = seen.known_before = true;
  return seen;
}

IslandSeen with(const client::Network& one) {
  auto seen = island();
  seen.before = seen.now = {one};
  return seen;
}

TEST(IslandFindings, ALineThatIsDownIsAProblemWithItsReasonAndAdvice) {
  const auto found = check_lines(with(network("down", "connection refused")), kNow).at(0);
  EXPECT_EQ(found.grade, Grade::kProblem);
  EXPECT_EQ(found.check, "line");
  EXPECT_EQ(found.what, "network knx-hall of island 6541 home: down for 5min: connection refused");
  EXPECT_THAT(found.fix, HasSubstr("12 attempts so far, next attempt in 20s"));
  EXPECT_THAT(found.fix, HasSubstr("networks: knx-hall:"));
}

TEST(IslandFindings, TheRemedyOfALineIsThatOfItsFinding) {
  using namespace model::findings;
  const auto fix = [](std::string_view finding) {
    auto one = network("down", "a sentence");
    one.line.finding = finding;
    return check_lines(with(one), kNow).at(0).fix;
  };
  EXPECT_THAT(fix(kCertificateExpired), HasSubstr("renew the certificate of the server"));
  EXPECT_THAT(fix(kCertificateEarly), HasSubstr("check the clock of the island's host"));
  EXPECT_THAT(fix(kCertificateName),
              AllOf(HasSubstr("name the server as its certificate does"), HasSubstr("next attempt")));
  EXPECT_THAT(fix(""), HasSubstr("check cable, power and network"));
}

TEST(IslandFindings, AHistoryThatIsNotWrittenIsAProblem) {
  auto seen = island();
  EXPECT_THAT(check_history(seen), IsEmpty());
  const auto found = [&](const std::string& status) {
    seen.history = status;
    return check_history(seen).at(0);
  };
  const auto failing = found(R"({"state":"failing","reason":"no space left","file":"/home.history","dropped":0})");
  EXPECT_EQ(failing.grade, Grade::kProblem);
  EXPECT_EQ(failing.what, "the history of island 6541 home (/home.history) is not written: no space left");
  EXPECT_THAT(failing.fix, HasSubstr("history.md#when-something-fails"));
  EXPECT_EQ(found(R"({"state":"opening","file":"f"})").grade, Grade::kNote);
  EXPECT_EQ(found(R"({"state":"recording","file":"f","dropped":0})").grade, Grade::kGood);
  const auto dropped = found(R"({"state":"recording","file":"f","dropped":12})");
  EXPECT_EQ(dropped.grade, Grade::kNote);
  EXPECT_THAT(dropped.what, HasSubstr("dropped 12 values"));
  EXPECT_EQ(found("broken").grade, Grade::kProblem);
}

TEST(IslandFindings, ABridgeThatIsNotConnectedIsAProblemAndWhatItsBrokerRefusesANote) {
  auto seen = island();
  EXPECT_THAT(check_bridges(seen), IsEmpty());
  const auto found = [&](const std::string& status) {
    seen.bridges["ha"] = status;
    return check_bridges(seen).at(0);
  };
  const auto refused = found(R"({"state":"refused","reason":"the broker does not know this user","peer":"b:1883"})");
  EXPECT_EQ(refused.grade, Grade::kProblem);
  EXPECT_EQ(refused.what,
            "bridge ha of island 6541 home (b:1883) is not connected: the broker does not know this user");
  EXPECT_THAT(refused.fix, HasSubstr("mqtt.md#troubles"));
  EXPECT_EQ(found(R"({"state":"up","reason":"the broker refuses x"})").grade, Grade::kNote);
  EXPECT_EQ(found(R"({"state":"up","reason":"","devices":1,"points":5})").grade, Grade::kGood);
}

TEST(IslandFindings, EachReasonOfARosBridgeIsANoteWithItsRemedy) {
  const struct {
    std::string_view finding;
    const char* remedy;
  } all[] = {{model::findings::kRosDomainEmpty, "ROS_DOMAIN_ID"},
             {model::findings::kRosGidsMixed, "a domain each"},
             {model::findings::kRosNamesClash, "rename one of the points"},
             {"unheard-of", "ros2.md#troubles"}};
  nlohmann::json status{{"state", "up"}, {"peer", "ROS domain 7"}, {"reason", "several"}};
  for (const auto& one : all) status["findings"].push_back({{"finding", one.finding}, {"text", "why"}});
  auto seen = island();
  seen.bridges["robots"] = status.dump();
  const auto found = check_bridges(seen);
  ASSERT_EQ(found.size(), std::size(all));
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].grade, Grade::kNote);
    EXPECT_EQ(found[i].what, "bridge robots of island 6541 home (ROS domain 7) is up; why");
    EXPECT_THAT(found[i].fix, HasSubstr(all[i].remedy));
  }
  for (const auto* broken : {R"("x")", "[7,{}]", "{}"}) {
    seen.bridges["robots"] = fmt::format(R"({{"state":"up","reason":"r","findings":{}}})", broken);
    EXPECT_THAT(check_bridges(seen), testing::Not(IsEmpty())) << broken;
  }
}

TEST(IslandFindings, DevicesThatTheirNamesMakeUnusableAreNotesWithTheReason) {
  auto zigbee = network("up");
  zigbee.properties["unusable"] =
      R"([{"address":"00124b0010000002","name":"with#hash","why":"the friendly name has a wildcard; rename it"},7])";
  const auto found = check_unusable(with(zigbee));
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].grade, Grade::kNote);
  EXPECT_THAT(found[0].what, HasSubstr("00124b0010000002 'with#hash' cannot be used: the friendly name"));
  EXPECT_THAT(found[0].fix, HasSubstr("zigbee.md"));
  for (const auto* nothing : {"[]", "no JSON", "{}"}) {
    zigbee.properties["unusable"] = nothing;
    EXPECT_THAT(check_unusable(with(zigbee)), IsEmpty()) << nothing;
  }
  EXPECT_THAT(check_unusable(with(network("up"))), IsEmpty());
}

TEST(IslandFindings, WhatALineOfZigbeeLacksIsExplainedOnItsPage) {
  auto zigbee = network("up", "no state of any of 3 devices: the access rules of the broker hide them");
  zigbee.id = "zigbee";
  const auto found = check_lines(with(zigbee), kNow).at(0);
  EXPECT_EQ(found.grade, Grade::kNote);
  EXPECT_THAT(found.what, HasSubstr("up for 5min, 3 of 3 devices reachable; no state of any of 3 devices"));
  EXPECT_THAT(found.fix, HasSubstr("zigbee.md#troubles"));
}

TEST(IslandFindings, SettingsOfTheServerThatDifferAreNotesWithWhatToSet) {
  auto zigbee = network("up");
  zigbee.id = "zigbee";
  zigbee.properties["settings"] =
      R"([{"setting":"advanced.last_seen","is":"disable","should":"ISO_8601","why":"no time of measurement"},3,{}])";
  const auto found = check_settings(with(zigbee));
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].grade, Grade::kNote);
  EXPECT_EQ(found[0].what, "network zigbee of island 6541 home: advanced.last_seen is disable: no time of measurement");
  EXPECT_THAT(found[0].fix, HasSubstr("set advanced.last_seen to ISO_8601"));
  zigbee.properties["settings"] = "[]";
  EXPECT_THAT(check_settings(with(zigbee)), IsEmpty());
  zigbee.properties["settings"] = "no JSON";
  EXPECT_THAT(check_settings(with(zigbee)), IsEmpty());
  EXPECT_THAT(check_settings(with(network("up"))), IsEmpty());
}

TEST(IslandFindings, WhatANetworkCannotUseIsListedWithItsReason) {
  auto knx = network("up");
  knx.properties["problems"] =
      R"([{"address":"6/0/2","what":"source","count":1,"reason":"nothing.there: no component has published this tuple","time":1767225540},
          {"address":"6/0/4","what":"exposure","count":3,"reason":"too large","time":1767225590}, 7])";
  const auto found = check_problems(with(knx), kNow);
  ASSERT_EQ(found.size(), 3U);
  EXPECT_EQ(found[0].grade, Grade::kNote);
  EXPECT_EQ(
      found[0].what,
      "network knx-hall of island 6541 home: 6/0/2 (source): nothing.there: no component has published this tuple");
  EXPECT_THAT(found[0].fix, HasSubstr("once, last 60s ago"));
  EXPECT_THAT(found[1].fix, HasSubstr("3 times, last 10s ago"));
  std::string many = "[";
  for (int i = 1; i <= 30; ++i) many += std::string(i > 1 ? "," : "") + R"({"address":"1/0/1","what":"value"})";
  knx.properties["problems"] = many + "]";
  const auto first = check_problems(with(knx), kNow);
  ASSERT_EQ(first.size(), 11U);
  EXPECT_THAT(first.back().what, HasSubstr("20 more problems"));
  knx.properties["problems"] = "no JSON";
  EXPECT_THAT(check_problems(with(knx), kNow), IsEmpty());
}

TEST(IslandFindings, ABrokerWithoutTlsOrUserIsANote) {
  const auto what_of = [](const std::string& broker) {
    auto zigbee = network("up");
    zigbee.properties["broker"] = broker;
    const auto found = check_brokers(with(zigbee));
    return found.empty() ? std::string() : found[0].what;
  };
  EXPECT_THAT(what_of(R"({"tls":false,"user":false})"), HasSubstr("without TLS and without a user: who reaches"));
  EXPECT_THAT(what_of(R"({"tls":false,"user":true})"), HasSubstr("without TLS: who reaches"));
  EXPECT_THAT(what_of(R"({"tls":true,"user":false})"), HasSubstr("without a user: who reaches"));
  EXPECT_EQ(what_of(R"({"tls":true,"user":true})"), "");
  EXPECT_THAT(check_brokers(with(network("up"))), IsEmpty());
}

TEST(IslandFindings, ALineThatDoesNotOpenIsAProblemAfterAWhile) {
  auto opening = network("connecting");
  EXPECT_EQ(check_lines(with(opening), kNow).at(0).grade, Grade::kProblem);
  opening.line.since = kNow - 3s;
  EXPECT_EQ(check_lines(with(opening), kNow).at(0).grade, Grade::kNote);
  EXPECT_EQ(check_lines(with(network("refused", "all tunnels taken")), kNow).at(0).grade, Grade::kProblem);
}

TEST(IslandFindings, ALineThatIsUpOrARecordingThatEndedIsGood) {
  EXPECT_EQ(check_lines(with(network("up")), kNow).at(0).grade, Grade::kGood);
  EXPECT_EQ(check_lines(with(network("ended", "end of the recording")), kNow).at(0).grade, Grade::kGood);
  EXPECT_EQ(check_lines(with(network("up", "nothing answers")), kNow).at(0).grade, Grade::kNote);
}

TEST(IslandFindings, DevicesThatCannotBeReachedAreNamedWhereTheLineIsNotTheReason) {
  auto one = network("up");
  EXPECT_THAT(check_devices(with(one)), IsEmpty());
  one.reachable = 1;
  EXPECT_THAT(check_devices(with(one)).at(0).what, HasSubstr("2 of 3 devices are not reachable"));
  one.line.line = "down";
  EXPECT_THAT(check_devices(with(one)), IsEmpty());
}

TEST(IslandFindings, ALossThatGrowsIsAProblemOneFromBeforeANote) {
  auto seen = with(network("up"));
  seen.numbers_before = {{"state-failures", 10}, {"gateway-delivered", 5}, {"gateway-malformed", 0}};
  seen.numbers = {{"state-failures", 13}, {"gateway-delivered", 900}, {"gateway-malformed", 0}};
  seen.before[0].properties = {{"dropped-readings", "7"}, {"line", "up"}};
  seen.now[0].properties = {{"dropped-readings", "7"}, {"line", "up"}};
  const auto found = check_losses(seen);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].grade, Grade::kProblem);
  EXPECT_THAT(found[0].what, HasSubstr("state-failures grew by 3 to 13"));
  EXPECT_EQ(found[1].grade, Grade::kNote);
  EXPECT_THAT(found[1].what, HasSubstr("network knx-hall of island 6541 home: dropped-readings = 7"));
}

TEST(IslandFindings, LossesThatTheFirstLookDidNotSeeAreNotes) {
  auto seen = with(network("up"));
  seen.numbers = {{"state-failures", 13}};
  seen.now[0].properties = {{"dropped-readings", "7"}};
  seen.known_before = false;
  auto found = check_losses(seen);
  ASSERT_EQ(found.size(), 2U);
  for (const auto& one : found) EXPECT_EQ(one.grade, Grade::kNote) << one.what;
  EXPECT_THAT(found[0].what, HasSubstr("state-failures = 13 since its start; first value unknown"));
  seen.known_before = true;
  seen.numbers_before = seen.numbers;
  seen.before.clear();
  found = check_losses(seen);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[1].grade, Grade::kNote) << "a network that came meanwhile";
  EXPECT_THAT(found[1].what, HasSubstr("dropped-readings = 7"));
}

TEST(IslandFindings, WithoutLossesAllIsGood) {
  auto seen = with(network("up"));
  seen.numbers_before = seen.numbers = {{"gateway-delivered", 5}, {"gateway-dropped-readings", 0}};
  EXPECT_EQ(check_losses(seen).at(0).grade, Grade::kGood);
}

TEST(IslandFindings, LittleRoomForStateAndRecordingsIsAProblem) {
  auto seen = island();
  EXPECT_THAT(check_disks(seen), IsEmpty());
  seen.numbers = {{"state-free-bytes", 99'000'000}, {"recorder-all-free-bytes", 5'000'000'000}};
  const auto found = check_disks(seen);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].grade, Grade::kGood);
  EXPECT_THAT(found[0].what, HasSubstr("5000 MB free for recorder-all"));
  EXPECT_EQ(found[1].grade, Grade::kProblem);
  EXPECT_THAT(found[1].what, HasSubstr("99 MB free for its state file"));
}

TEST(IslandFindings, ARecorderThatDropsRecordsIsAProblem) {
  auto seen = island();
  seen.properties = {{"recorder-all-state", "recording"}, {"recorder-night-state", "dropping records: disk is full"}};
  const auto found = check_disks(seen);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].grade, Grade::kProblem);
  EXPECT_THAT(found[0].what, HasSubstr("recorder-night-state: dropping records: disk is full"));
  seen.properties = {{"recorder-all-state", "stopped"}};
  const auto stopped = check_disks(seen);
  ASSERT_EQ(stopped.size(), 1U);
  EXPECT_EQ(stopped[0].grade, Grade::kNote);
  EXPECT_THAT(stopped[0].what, HasSubstr("stopped by a user"));
}

TEST(IslandFindings, AClockThatIsOffIsAProblem) {
  auto seen = island();
  EXPECT_THAT(check_clock(seen, kNow), IsEmpty()) << "an older version does not tell";
  const auto offset = [&](Duration by) {
    seen.clock_offset = by;
    return check_clock(seen, kNow).at(0);
  };
  EXPECT_EQ(offset(-1s).grade, Grade::kGood);
  EXPECT_EQ(offset(3500ms).grade, Grade::kProblem);
  EXPECT_THAT(offset(3500ms).what, HasSubstr("of island 6541 home (attic) is 3.5 s ahead of this one"));
  EXPECT_THAT(offset(-3500ms).what, HasSubstr("3.5 s behind this one"));
  EXPECT_THAT(offset(-1'767'225'000s).what, HasSubstr("was never set"));
  EXPECT_THAT(check_clock(seen, WallTime(1h)).at(0).what, HasSubstr("the clock of this host says"));
}

TEST(IslandFindings, AlertsOfTheIslandThatNoOtherCheckSays) {
  auto seen = island();
  EXPECT_THAT(check_alerts(seen), IsEmpty());
  seen.alerts.all = {
      {"line-down", "proxy.knx-hall", model::Severity::kProblem, kNow, "down", "cable"},
      {"battery-low", "proxy.knx-hall.7", model::Severity::kWarning, kNow, "7: the battery is low", "change it"}};
  const auto found = check_alerts(seen);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].grade, Grade::kNote);
  EXPECT_EQ(found[0].what, "island 6541 home: 7: the battery is low");
  EXPECT_EQ(found[0].fix, "change it");
}

TEST(IslandFindings, DevicesThatWaitForADecisionAreNamed) {
  auto seen = island();
  EXPECT_THAT(check_inbox(seen), IsEmpty());
  seen.numbers = {{"inbox-waiting", 2}};
  EXPECT_THAT(check_inbox(seen).at(0).what, HasSubstr("2 devices wait of island 6541 home for a decision"));
  EXPECT_EQ(check_inbox(seen).at(0).fix, "rubicon inbox --island 6541");
}

TEST(IslandFindings, SayWhoCanCommandTheIsland) {
  client::Options options;
  EXPECT_THAT(check_access(island(), options).what, HasSubstr("anybody on this host may read and command island 6541"));
  options.interfaces = {"eth0"};
  EXPECT_THAT(check_access(island(), options).what, HasSubstr("`trust_lan: no` only prevents mistakes"));
  EXPECT_THAT(check_access(island(), options).fix, HasSubstr("what `lan` may do"));
  auto seen = island();
  EXPECT_EQ(check_access_of_host(seen, "/run/rubicon").what,
            "whoever may enter /run/rubicon may read and command island 6541");
  seen.numbers = {{"rights-refused", 0}};
  EXPECT_EQ(check_access_of_host(seen, "/run/rubicon").what,
            "island 6541 asks its rights who of this host may do what");
  EXPECT_THAT(check_access(seen, options).what, HasSubstr("are the member `lan`; its rights say what `lan` may do"));
}

TEST(IslandFindings, AnIslandThatHadCertificatesForDdsIsAProblemWithTwoWaysOut) {
  auto seen = island();
  EXPECT_THAT(check_held_back(seen), IsEmpty());
  seen.properties["dds-held-back"] = "tuples.trust";
  const auto found = check_held_back(seen);
  ASSERT_THAT(found, testing::SizeIs(1));
  EXPECT_EQ(found[0].grade, Finding::Grade::kProblem);
  EXPECT_THAT(found[0].what, HasSubstr("had certificates for DDS (tuples.trust), which this release does not have"));
  EXPECT_THAT(found[0].fix, testing::AllOf(HasSubstr("sites.md"), HasSubstr("`tuples: {trust: no}`")));
}

TEST(IslandFindings, WhatRightsRefusedIsNamed) {
  auto seen = island();
  EXPECT_THAT(check_rights(seen), IsEmpty());
  seen.numbers = {{"rights-refused", 3}};
  EXPECT_THAT(check_rights(seen).at(0).what, HasSubstr("refused 3 requests by its rights"));
}

TEST(Findings, ParticipantsThatShowNoComponentAreCounted) {
  EXPECT_THAT(check_silent_participants(0, 3), IsEmpty());
  EXPECT_THAT(check_silent_participants(1, 3).at(0).what, HasSubstr("1 participant of domain 3 shows no component"));
}

/// As GitHub makes it of a heading.
std::string anchor_of(std::string heading) {
  heading.erase(0, heading.find_first_not_of("# "));
  std::string anchor;
  for (const char c : heading) {
    if (c == ' ') anchor += '-';
    if (std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '_')
      anchor += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return anchor;
}

/// What the sources of the command line pass to page().
std::set<std::string> pages_named() {
  static const std::regex kPage(R"re(page\("([^"]+)"\))re");
  std::set<std::string> found;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(RUBICON_SOURCE_DIR "/apps/rubicon")) {
    if (entry.path().extension() != ".cpp") continue;
    std::ifstream file(entry.path());
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    for (std::sregex_iterator it(text.begin(), text.end(), kPage), end; it != end; ++it) found.insert((*it)[1].str());
  }
  return found;
}

TEST(IslandFindings, PointToPagesAndHeadingsThatExistAndAreInstalled) {
  const auto pages = pages_named();
  ASSERT_GT(pages.size(), 4U);
  std::ifstream packaging(RUBICON_SOURCE_DIR "/packaging/CMakeLists.txt");
  const std::string installed{std::istreambuf_iterator<char>(packaging), {}};
  for (const auto& name : pages) {
    EXPECT_EQ(page(name), "docs/" + name) << "nothing is installed with the test program";
    const auto file = name.substr(0, name.find('#'));
    EXPECT_THAT(installed,
                HasSubstr("install(DIRECTORY ${CMAKE_SOURCE_DIR}/docs DESTINATION ${CMAKE_INSTALL_DOCDIR})"));
    std::ifstream text(RUBICON_SOURCE_DIR "/docs/" + file);
    ASSERT_TRUE(text) << file;
    bool found = name == file;
    for (std::string line; std::getline(text, line);)
      found = found || (line.starts_with("#") && file + "#" + anchor_of(line) == name);
    EXPECT_TRUE(found) << name;
  }
}

TEST(IslandFindings, AnInterfaceWithoutAnAddressIsAProblemAndAChangedOneANote) {
  auto seen = island();
  EXPECT_THAT(check_interfaces_of(seen), IsEmpty());
  seen.properties["dds-interfaces"] =
      R"({"interfaces":[{"name":"eth0","address":"","lack":"has no IPv4 address"},)"
      R"({"name":"wlan0","address":"10.0.0.2","lack":""}],"changes":2,"changed":1767225600})";
  const auto found = check_interfaces_of(seen);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].grade, Grade::kProblem);
  EXPECT_EQ(found[0].what, "interface eth0 of island 6541 home has no IPv4 address: it reaches no other host");
  EXPECT_EQ(found[1].grade, Grade::kNote);
  EXPECT_THAT(found[1].what, HasSubstr("changed 2 times since its start, at last at 2026-01-01"));
  for (const auto* rubbish : {"", "5", R"({"interfaces":7})", R"({"interfaces":[7,null,{"lack":3}],"changes":"x"})"}) {
    seen.properties["dds-interfaces"] = rubbish;
    EXPECT_THAT(check_interfaces_of(seen), IsEmpty()) << rubbish;
  }
}

TEST(Losses, AreKnownByTheWordsOfTheirNames) {
  for (const auto* name : {"dropped-readings", "state-failures", "recorder-all-dropped", "refused-busy", "bad-frames",
                           "telegrams-lost", "undeliverable", "not-acknowledged", "unknown-devices", "secure-replays",
                           "secure-wrong-mac", "secure-plain-frames", "secure-old", "data-secure-wrong-mac",
                           "data-secure-plain-dropped", "data-secure-unknown-sender", "data-secure-old"})
    EXPECT_TRUE(counts_loss(name)) << name;
  for (const auto* name :
       {"readings", "devices", "attempts", "next-attempt", "state-bytes", "state-free-bytes", "tuples-cached",
        "gateway-delivered", "inbox-waiting", "port", "gateway-duplicates", "secure-sessions", "secure-sent",
        "secure-unverified", "data-secure-sent", "data-secure-received", "data-secure-tool-access"})
    EXPECT_FALSE(counts_loss(name)) << name;
}

TEST(Losses, ACounterThatBeganAgainGrewFromZero) {
  EXPECT_EQ(growth_of({{"a", 10}, {"b", 3}}, {{"a", 4}, {"b", 3}, {"c", 1}}), (Counters{{"a", 4}, {"c", 1}}));
  EXPECT_EQ(losses_text({{"bad-frames", 5}, {"lost", 1}}, {{"lost", 1}}), "bad-frames 5, lost 1 (+1)");
}

}  // namespace
}  // namespace rubicon::cli
