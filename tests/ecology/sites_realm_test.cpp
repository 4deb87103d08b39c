#include <chrono>
#include <thread>

#include "ecology/realm_of_sites.h"

namespace rubicon::ecology {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using support::ask;
using support::Process;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

TEST_F(RealmOfSites, WhoIsRevokedReceivesNothingMoreThoughTheBrokerKnowsNothing) {
  make_realm();
  join("lab", {"--island", "2", "--role", "admin"});
  join("guest", {"--island", "3", "--role", "admin"});
  join("desk", {"--role", "admin"});
  start_broker();
  const auto hall = island(1, mqtt("hall", "authority")), lab = island(2, mqtt("lab")),
             guest = island(3, mqtt("guest"));
  const std::string value = "1:proxy.dummy-1.hall.sensor.temperature-1.value",
                    command = "1:proxy.dummy-1.hall.actuator.switch-1.command",
                    state = "1:proxy.dummy-1.hall.actuator.switch-1.value";
  for (auto* one : {lab.get(), guest.get()}) {
    ASSERT_TRUE(ask(*one, "subscribe " + value + " min=50ms").value("ok", false));
    ASSERT_TRUE(reaches(*one, value, 5)) << one->errors();
  }
  ASSERT_TRUE(ask(*guest, "set " + command + " on").value("ok", false));
  trust("authority", {"revoke", "guest"});
  for (int i = 0;
       i < 4000 && trust("lab", {"show", "--json"}).output.find("\"revoked\":[\"guest\"]") == std::string::npos;)
    ++i;
  EXPECT_THAT(trust("lab", {"show", "--json"}).output, HasSubstr("\"revoked\":[\"guest\"]")) << hall->errors();
  ASSERT_TRUE(reaches(*lab, value, sequence(*lab, value) + 5)) << "what was under way has arrived";
  const auto last = sequence(*guest, value);
  ASSERT_TRUE(reaches(*lab, value, sequence(*lab, value) + 20)) << lab->errors();
  EXPECT_EQ(sequence(*guest, value), last);
  EXPECT_FALSE(ask(*guest, "set " + command + " off").value("ok", true));
  EXPECT_EQ(ask(*lab, "get " + state).value("value", ""), "on");
  EXPECT_TRUE(ask(*lab, "set " + command + " off").value("ok", false));
  EXPECT_THAT(lab->errors(), Not(HasSubstr("lost")));
  const auto islands = run("desk", {"islands", "--config", tool("desk", mqtt("desk"))});
  EXPECT_THAT(islands.output, AllOf(HasSubstr("site1"), HasSubstr("site2"), Not(HasSubstr("site3"))));
  EXPECT_THAT(trust("guest", {"show", "--json"}).output, HasSubstr("\"revoked\":[\"guest\"]"));
}

/// No program runs where members are added and revoked.
TEST_F(RealmOfSites, OneCommandBringsARevocationToTheBroker) {
  make_realm();
  join("lab", {"--island", "2"});
  start_broker();
  const auto lab = island(2, mqtt("lab"));
  trust("authority", {"add", "guest", "--here"});
  trust("authority", {"revoke", "guest"});
  const auto knows = [&] { return trust("lab", {"show"}).output.find("guest") != std::string::npos; };
  EXPECT_FALSE(knows());
  EXPECT_EQ(run("authority", {"islands", "--config", tool("hall", mqtt("hall", "authority"))}).code, 0);
  for (int i = 0; i < 2000 && !knows();) ++i;
  EXPECT_TRUE(knows()) << lab->errors();
}

TEST_F(RealmOfSites, TheDoctorOfAMemberNamesWhoIsNoneAndWhatIsOld) {
  make_realm(true);
  join("desk", {"--role", "admin"});
  std::filesystem::copy(folder_ / "desk-realm/realm.p7s", folder_ / "old.p7s");
  ASSERT_EQ(support::run_to_end({"mosquitto_passwd", "-b", folder_ / "broker/passwords", "stranger", "secret"}).code,
            0);
  start_broker();
  const auto hall = island(1, mqtt("hall", "authority"));
  const auto config = tool("desk", mqtt("desk"));
  const std::vector<std::string> words{"doctor", "--for", "100ms", "--config", config};
  ASSERT_TRUE(until("desk", words, "island 1 site1 answers")) << hall->errors();
  const auto well = run("desk", words);
  EXPECT_EQ(well.code, 0) << well.output;
  EXPECT_THAT(well.output, AllOf(HasSubstr("connected with the broker 127.0.0.1:8883 as desk, by MQTT 5 with TLS; "
                                           "space default has "),
                                 HasSubstr("the rights of the broker 127.0.0.1:8883 protect others from desk")));
  const auto stranger = [&](const std::string& topic) {
    const auto shown =
        support::run_to_end({"mosquitto_pub", "-h", "127.0.0.1", "-p", "8884", "--cafile",
                             folder_ / "authority-realm/ca.pem", "-u", "stranger", "-P", "secret", "-r", "-q", "1",
                             "-m", "x", "-t", "rubicon-space/1/default/p/0/stranger/" + topic});
    EXPECT_EQ(shown.code, 0) << shown.errors;
  };
  stranger("000000000000/70000");
  trust("authority", {"add", "more", "--here"});
  const auto ill = run("desk", words);
  EXPECT_EQ(ill.code, 1) << ill.output;
  EXPECT_THAT(ill.output, AllOf(HasSubstr("has users that the realm Rubicon"), HasSubstr("does not have: stranger"),
                                HasSubstr("has 1 component without a connection: 70000 of stranger")));
  const auto knows = [&] { return trust("desk", {"show"}).output.find("more") != std::string::npos; };
  for (int i = 0; i < 1000 && !knows(); ++i) run("desk", {"islands", "--config", config});
  EXPECT_TRUE(knows()) << "a tool keeps what it hears";
  std::filesystem::copy(folder_ / "old.p7s", folder_ / "desk-realm/realm.p7s",
                        std::filesystem::copy_options::overwrite_existing);
  EXPECT_THAT(run("desk", words).output, HasSubstr("the one that hall shows has "));
  const auto key = folder_ / "desk-realm/members/desk/key.pem";
  EXPECT_THAT(run("desk", words).output, Not(HasSubstr("others may read this key")));
  std::filesystem::permissions(key, std::filesystem::perms::others_read, std::filesystem::perm_options::add);
  const auto open = run("desk", words);
  EXPECT_EQ(open.code, 1);
  EXPECT_THAT(open.output, HasSubstr(key + ": others may read this key"));
}

TEST_F(SitesOfABroker, TheDoctorSaysWhyThereIsNoBroker) {
  const std::vector<std::string> words{"doctor", "--for", "100ms", "--broker", "127.0.0.1"};
  const auto down = run("laptop", words);
  EXPECT_EQ(down.code, 1);
  EXPECT_THAT(down.output,
              AllOf(HasSubstr("no connection with the broker: MQTT 127.0.0.1:1883: cannot connect: Connection "
                              "refused"),
                    HasSubstr("no broker listens there")));
  EXPECT_THAT(down.output, AllOf(HasSubstr("programs of this host meet in"), Not(HasSubstr("complaint"))));
  EXPECT_THAT(run("laptop", {"doctor", "--engine", "mqtt", "--broker", "127.0.0.1"}).output, Not(HasSubstr("meet in")));
  support::Mosquitto broker({.users = {{"ann", "secret"}}});
  ASSERT_TRUE(broker.comes_up());
  const auto password = folder_ / "password";
  std::ofstream(password) << "wrong\n";
  auto with = words;
  with.insert(with.end(), {"--broker-user", "ann", "--broker-password-file", password});
  const auto wrong = run("laptop", with);
  EXPECT_EQ(wrong.code, 1);
  EXPECT_THAT(wrong.output,
              AllOf(HasSubstr("no connection with the broker"), HasSubstr("its password is another one")));
}

TEST_F(SitesOfABroker, TheDoctorSaysThatABrokerProtectsNobody) {
  support::Mosquitto broker;
  const auto one = island(1, "{broker: \"127.0.0.1\"}");
  const std::vector<std::string> words{"doctor", "--for", "100ms", "--broker", "127.0.0.1"};
  ASSERT_TRUE(until("laptop", words, "island 1 site1 answers"));
  const auto told = run("laptop", words);
  EXPECT_EQ(told.code, 0) << told.output;
  EXPECT_THAT(told.output,
              HasSubstr("lets any client write in the name of others: the names of its users prove nothing"));
}

}  // namespace
}  // namespace rubicon::ecology
