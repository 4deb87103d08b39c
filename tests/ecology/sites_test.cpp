#include "ecology/sites.h"
#include "support/http_text.h"

namespace rubicon::ecology {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using support::ask;
using support::Process;
using testing::HasSubstr;

TEST_F(SitesOfABroker, AreSeenAndCommandedFromEachOtherAndFromALaptop) {
  support::Mosquitto broker;
  const auto one = island(1, "{broker: \"127.0.0.1\", trust_broker: yes}");
  const auto two = island(2, "{broker: \"127.0.0.1\", trust_broker: yes}");
  ASSERT_TRUE(ask(*one, "subscribe 2:proxy.dummy-1.hall.sensor.temperature-1.value min=100ms").value("ok", false));
  EXPECT_TRUE(support::until(
      *one, "get 2:proxy.dummy-1.hall.sensor.temperature-1.value", 60s,
      [](const json& tuple) { return tuple.value("sequence", 0) > 5 && !tuple.value("value", "").empty(); }))
      << "its demand reaches the owner, which measures: " << one->errors() << two->errors();
  const std::vector<std::string> laptop{"--broker", "127.0.0.1"};
  const auto with = [&](std::vector<std::string> words) {
    words.insert(words.end(), laptop.begin(), laptop.end());
    return words;
  };
  EXPECT_TRUE(until("laptop", with({"islands"}), "site2"));
  EXPECT_TRUE(until("laptop", with({"set", "2:proxy.dummy-1.hall.actuator.switch-1.command", "on"}), ""));
  EXPECT_TRUE(until("laptop", with({"get", "2:proxy.dummy-1.hall.actuator.switch-1.value"}), "on"));
  const auto history = run("laptop", with({"history", "site2", "info", "--json"}));
  EXPECT_THAT(history.output, HasSubstr("site2.history")) << history.errors;
  Process page(at("laptop", with({RUBICON_BINARY_DIR "/bin/rubicon", "web", "--listen", "127.0.0.1:0"})));
  const auto line = page.line_with("http://127.0.0.1:");
  ASSERT_TRUE(line) << page.errors();
  const auto port = std::stoi(line->substr(line->rfind(':') + 1));
  std::string shown;
  const auto all = testing::AllOf(HasSubstr("site1"), HasSubstr("site2"));
  for (int i = 0; i < 1000 && !testing::Value(shown, all); ++i) {
    std::ignore = page.has_settled();
    shown = support::http_text(port, "GET /api/v1/islands");
  }
  EXPECT_THAT(shown, all);
  EXPECT_EQ(run("laptop", {"islands"}).code, 8) << "without the broker it sees nobody";
  EXPECT_EQ(run("site1", {"set", "1:proxy.dummy-1.hall.actuator.switch-1.command", "off"}).code, 0) << "on its host";
  broker.kill();
  broker.start();
  EXPECT_TRUE(until("laptop", with({"set", "1:proxy.dummy-1.hall.actuator.switch-1.command", "on"}), ""));
  EXPECT_TRUE(until("laptop", with({"get", "1:proxy.dummy-1.hall.actuator.switch-1.value"}), "on"));
}

TEST_F(SitesOfABroker, WithoutRightsAtTheBrokerNobodyCommands) {
  support::Mosquitto broker;
  const auto one = island(1, "{broker: \"127.0.0.1\"}");
  EXPECT_TRUE(until("laptop", {"islands", "--broker", "127.0.0.1"}, "site1"));
  const auto refused =
      run("laptop", {"set", "1:proxy.dummy-1.hall.actuator.switch-1.command", "on", "--broker", "127.0.0.1"});
  EXPECT_NE(refused.code, 0);
  EXPECT_THAT(refused.output + refused.errors, HasSubstr("refused"));
}

TEST_F(SitesOfABroker, WithoutTheBrokerAnIslandObeysOnItsHost) {
  support::Mosquitto broker;
  const auto one = island(1, "{broker: \"127.0.0.1\", trust_broker: yes}");
  ASSERT_TRUE(until("laptop", {"islands", "--broker", "127.0.0.1"}, "site1"));
  broker.kill();
  EXPECT_EQ(run("site1", {"set", "1:proxy.dummy-1.hall.actuator.switch-1.command", "on"}).code, 0) << one->errors();
  EXPECT_EQ(run("site1", {"get", "1:proxy.dummy-1.hall.actuator.switch-1.value"}).output, "on\n");
}

/// A realm with the commands of docs/sites.md, on a broker with exactly what they wrote.
TEST_F(SitesOfABroker, OfARealmDoWhatRolesAndRulesGiveThem) {
  const auto realm = (folder_ / "authority");
  const auto trust = [&](std::vector<std::string> words) {
    words.insert(words.begin(), "trust");
    words.insert(words.end(), {"--realm", realm});
    const auto outcome = run("authority", std::move(words));
    EXPECT_EQ(outcome.code, 0) << outcome.output << outcome.errors;
    return outcome;
  };
  trust({"init", "--broker", "127.0.0.1"});
  trust({"broker", "mosquitto", "--out", (folder_ / "broker")});
  for (const auto* member : {"hall", "lab", "desk", "guest"}) {
    std::vector<std::string> words{"add", member, "--here"};
    if (std::string_view(member) == "hall") words.insert(words.end(), {"--island", "1"});
    if (std::string_view(member) == "lab") words.insert(words.end(), {"--island", "2"});
    if (std::string_view(member) == "desk") words.insert(words.end(), {"--role", "admin"});
    trust(words);
  }
  const auto bundle = folder_ / "ann.trust", phrase = folder_ / "ann.phrase", home = folder_ / "home";
  trust({"add", "ann", "--role", "admin", "--out", bundle, "--phrase-file", phrase});
  Process broker({"mosquitto", "-c", (folder_ / "broker/mosquitto.conf")});
  const auto mqtt = [&](const std::string& member) {
    const auto of = realm + "/members/" + member;
    return "{broker: {host: 127.0.0.1, port: 8883, tls: {ca: " + realm + "/ca.pem, certificate: " + of +
           "/certificate.pem, key: " + of + "/key.pem}}}";
  };
  const auto one = island(1, mqtt("hall")), two = island(2, mqtt("lab"));
  const auto tool = [&](const std::string& member) {
    const auto file = (folder_ / (member + ".yaml"));
    std::ofstream(file) << "tuples: {mqtt: " << mqtt(member) << "}\n";
    return file;
  };
  const auto *value = "2:proxy.dummy-1.hall.actuator.switch-1.value",
             *command = "2:proxy.dummy-1.hall.actuator.switch-1.command";
  EXPECT_TRUE(until("desk", {"islands", "--config", tool("desk")}, "site2")) << two->errors() << broker.errors();
  EXPECT_TRUE(until("desk", {"set", command, "on", "--config", tool("desk")}, "")) << two->errors();
  EXPECT_TRUE(until("desk", {"get", value, "--config", tool("desk")}, "on"));
  const auto guest = run("guest", {"set", command, "off", "--config", tool("guest")});
  EXPECT_NE(guest.code, 0) << "without a role and without rules it may nothing";
  EXPECT_NE(run("guest", {"get", value, "--config", tool("guest")}).output, "on\n");
  EXPECT_TRUE(until("desk", {"get", value, "--config", tool("desk")}, "on"));

  // A person who joins needs no option from then on.
  const auto joined = run(
      "home", {"trust", "join", bundle, "--yes", "--phrase-file", phrase, "--realm", home + "/.config/rubicon/realm"});
  const auto file = home + "/.config/rubicon/ecology.yaml";
  EXPECT_THAT(joined.output, testing::HasSubstr("tools        " + file)) << joined.errors;
  std::ofstream(file, std::ios::app) << "  folder: " << meetings_["home"]->path() << "\n";
  const auto seen = support::run_to_end(
      {"env", "-u", "RUBICON_FOLDER", "HOME=" + home, RUBICON_BINARY_DIR "/bin/rubicon", "get", value});
  EXPECT_THAT(seen.output, testing::HasSubstr("on")) << seen.errors;
  EXPECT_NE(run("home", {"get", value}).code, 0) << "RUBICON_FOLDER says where to look";
}

}  // namespace
}  // namespace rubicon::ecology
