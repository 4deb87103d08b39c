#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <functional>
#include <memory>

#include "support/mosquitto.h"
#include "support/private_network.h"
#include "support/process.h"
#include "transport/mqtt_client.h"
#include "transport/worlds.h"
#include "trust/site/realm_fixture.h"
#include "trust/site/site_identity.h"

namespace rubicon::trust::site {
namespace {

namespace fs = std::filesystem;
using support::Process;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using transport::MqttClient;
using transport::MqttOptions;

constexpr std::uint16_t kPort = 8883;

/// A mosquitto with exactly the files that the realm wrote, and members on other hosts.
class LiveBroker : public testing::Test {
 protected:
  void SetUp() override {
    if (!alone_.entered()) GTEST_SKIP() << alone_.reason();
    if (const auto missing = support::Mosquitto::missing(); !missing.empty()) GTEST_SKIP() << missing;
    ASSERT_TRUE(init(home_, {"Rubicon", {"broker.test", "127.0.0.1"}}, now()));
  }
  static WallTime now() { return std::chrono::floor<std::chrono::microseconds>(std::chrono::system_clock::now()); }
  static std::string user() { return ::geteuid() == 0 && service_user("mosquitto") ? "mosquitto" : ""; }

  void set_up(bool passwords = false) const {
    const auto made = set_up_mosquitto(home_, {{broker_, broker_ + "/state", user(), kPort, passwords}, ""}, {}, now());
    ASSERT_TRUE(made) << made.error().text;
  }
  void start(bool passwords = false) {
    set_up(passwords);
    process_ = std::make_unique<Process>(std::vector<std::string>{"mosquitto", "-c", broker_ + "/mosquitto.conf"});
    ASSERT_TRUE(world_.until([] { return listens(kPort); })) << process_->errors();
  }
  static bool listens(std::uint16_t port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const int probe = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const bool there = ::connect(probe, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
    ::close(probe);
    return there;
  }

  /// Joins on a host of its own.
  SitePlace joined(const std::string& name) const {
    auto issued = add(home_, {name, {}, {}, 100}, now());
    if (!issued) throw std::runtime_error(issued.error().text);
    return taken(name, *issued);
  }
  SitePlace joined_with_password(const std::string& name) const {
    auto added = add_with_password(home_, {name, {}, {}, 100}, now());
    if (!added) throw std::runtime_error(added.error().text);
    return taken(name, added->issued);
  }
  SitePlace taken(const std::string& name, const SiteIssued& issued) const {
    const fs::path folder = folder_ / ("of-" + name);
    const auto joined = join_site(folder, issued.bundle, issued.phrase.view(), now());
    if (!joined) throw std::runtime_error(joined.error().text);
    return {folder, name};
  }

  static MqttOptions options_of(const SitePlace& place) {
    MqttOptions options;
    options.host = "127.0.0.1";
    options.version = transport::MqttVersion::k5;
    options.tls = transport::MqttTls{place.authority(), {}, {}, "broker.test"};
    options.port = place.has_password() ? kPort + 1 : kPort;
    if (place.has_password()) {
      options.user = place.user;
      options.password = content_of(place.password());
      options.password.pop_back();
    } else {
      options.tls->certificate_file = place.certificate();
      options.tls->key_file = place.key();
    }
    return options;
  }
  void connect(MqttClient& client, const MqttOptions& options) {
    client.open(world_.local, options);
    ASSERT_TRUE(world_.until([&] { return client.connected > 0 || !client.failures.empty(); }));
    ASSERT_THAT(client.failures, IsEmpty()) << client.failures[0].text;
  }
  bool is_accepted(const MqttOptions& options) { return !refusal(options); }
  /// Why the broker, or the client, does not want to; nullopt: the connection is there.
  std::optional<Error> refusal(const MqttOptions& options) {
    MqttClient client;
    client.open(world_.local, options);
    EXPECT_TRUE(world_.until([&] { return client.connected > 0 || !client.failures.empty(); }));
    if (client.failures.empty()) return {};
    return client.failures[0];
  }
  /// The broker reads its files some time after it was told.
  static bool in_the_end(const std::function<bool()>& so) {
    for (int i = 0; i < 1000; ++i) {
      if (so()) return true;
    }
    return false;
  }
  /// Empty if the broker took it.
  std::string publish(MqttClient& client, const std::string& topic, const std::string& payload, bool retain = false) {
    const auto done = [&] { return client.taken.size() + client.not_taken.size(); };
    const auto before = done(), refused = client.not_taken.size();
    EXPECT_TRUE(client.line->publish({topic, payload, retain, 1}));
    EXPECT_TRUE(world_.until([&] { return done() > before || !client.failures.empty(); }));
    return client.not_taken.size() > refused ? client.not_taken.back() : "";
  }
  /// The broker has it when this returns: it answers what came behind it.
  void subscribe(MqttClient& client, const std::string& filter) {
    ASSERT_TRUE(client.line->subscribe(filter));
    std::ignore = publish(client, "fence", "");
    client.not_taken.clear();
  }
  void reload() const { process_->signal(SIGHUP); }

  const support::PrivateNetwork alone_;
  const support::Folder folder_;
  const fs::path home_ = folder_ / "home";
  const std::string broker_ = folder_ / "broker";
  transport::MachineWorld world_;
  std::unique_ptr<Process> process_;
};

TEST_F(LiveBroker, MembersReachEachOtherByTheirCertificates) {
  start();
  MqttClient hall, ann;
  connect(hall, options_of(joined("hall")));
  connect(ann, options_of(joined("ann")));
  subscribe(hall, "rubicon-space/1/city/to/hall/#");
  subscribe(ann, "rubicon-space/1/city/p/#");
  EXPECT_EQ(publish(hall, "rubicon-space/1/city/p/0/hall/0a0", "up", true), "");
  EXPECT_EQ(publish(ann, "rubicon-space/1/city/to/hall/0a0/ann/0b0", "hello"), "");
  ASSERT_TRUE(world_.until([&] { return !hall.received.empty() && !ann.received.empty(); }));
  EXPECT_THAT(hall.received, ElementsAre("rubicon-space/1/city/to/hall/0a0/ann/0b0 hello"));
  EXPECT_THAT(ann.received[0], HasSubstr("p/0/hall/0a0 up"));
}

TEST_F(LiveBroker, AMemberWritesNothingInTheNameOfAnother) {
  start();
  MqttClient hall, lab;
  connect(hall, options_of(joined("hall")));
  connect(lab, options_of(joined("lab")));
  subscribe(hall, "rubicon-space/1/#");
  for (const auto* topic : {"rubicon-space/1/city/p/0/hall/0a0", "rubicon-space/1/city/p/0/hall/0a0/6541",
                            "rubicon-space/1/city/to/ann/0a0/hall/0b0", "rubicon-space/1/city/p/lab", "other/topic",
                            "rubicon-space/1/city/to/ann/0a0/hall/lab", "rubicon-space/2/city/p/0/lab/0a0"}) {
    EXPECT_THAT(publish(lab, topic, "forged", true), HasSubstr(topic)) << "is taken";
  }
  EXPECT_EQ(publish(lab, "rubicon-space/1/city/p/0/lab/0a0", "last", true), "");
  ASSERT_TRUE(world_.until([&] { return !hall.received.empty(); }));
  EXPECT_THAT(hall.received, ElementsAre("rubicon-space/1/city/p/0/lab/0a0 last"));
}

TEST_F(LiveBroker, AnInboxIsReadByItsOwnerOnly) {
  start();
  MqttClient hall, lab, ann;
  connect(hall, options_of(joined("hall")));
  connect(lab, options_of(joined("lab")));
  connect(ann, options_of(joined("ann")));
  subscribe(hall, "rubicon-space/1/city/to/hall/#");
  for (const auto* filter : {"#", "rubicon-space/1/city/to/hall/#", "rubicon-space/1/+/to/#"}) subscribe(lab, filter);
  EXPECT_EQ(publish(lab, "rubicon-space/1/city/to/lab/0c0/lab/0c0", "fence"), "");
  ASSERT_TRUE(world_.until([&] { return !lab.received.empty(); }));
  lab.received.clear();
  EXPECT_EQ(publish(ann, "rubicon-space/1/city/to/hall/0a0/ann/0b0", "secret"), "");
  EXPECT_EQ(publish(ann, "rubicon-space/1/city/to/lab/0c0/ann/0b0", "last"), "");
  ASSERT_TRUE(world_.until([&] { return !hall.received.empty() && !lab.received.empty(); }));
  EXPECT_THAT(hall.received, SizeIs(1));
  for (const auto& message : lab.received) EXPECT_THAT(message, testing::Not(HasSubstr("secret")));
}

TEST_F(LiveBroker, WhoHasNoCertificateOfThisRealmIsRefused) {
  start();
  const auto hall = joined("hall");
  auto without = options_of(hall);
  without.tls->certificate_file = without.tls->key_file = "";
  EXPECT_FALSE(is_accepted(without));
  const auto other = folder_ / "other";
  ASSERT_TRUE(init(other, {"Rubicon", {"broker.test"}}, now()));
  ASSERT_TRUE(add_here(other, {"hall", {}, {}, 100}, now()));
  auto foreign = options_of({other, "hall"});
  foreign.tls->ca_file = hall.authority();
  EXPECT_FALSE(is_accepted(foreign));
  // Nor takes a member another broker for that of its realm.
  auto strange = options_of(hall);
  strange.tls->ca_file = (fs::path(other) / kAuthorityFile).string();
  EXPECT_THAT(refusal(strange).value_or(Error{}).text, HasSubstr("certificate"));
  auto misnamed = options_of(hall);
  misnamed.tls->server_name = "elsewhere.test";
  EXPECT_THAT(refusal(misnamed).value_or(Error{}).text, HasSubstr("hostname mismatch"));
  // The certificate of a member is none of a broker, and the other way round.
  auto as_broker = options_of(hall);
  as_broker.tls->certificate_file = broker_ + "/broker.pem";
  as_broker.tls->key_file = broker_ + "/broker.key";
  EXPECT_FALSE(is_accepted(as_broker));
  MqttClient good;
  connect(good, options_of(hall));
}

TEST_F(LiveBroker, WhoIsRevokedIsOutAfterAReload) {
  start();
  const auto hall_place = joined("hall"), desk_place = joined("desk");
  MqttClient hall, desk;
  connect(hall, options_of(hall_place));
  connect(desk, options_of(desk_place));
  subscribe(desk, "rubicon-space/1/city/p/#");
  subscribe(desk, "rubicon-space/1/city/to/desk/#");
  EXPECT_EQ(publish(desk, "rubicon-space/1/city/p/0/desk/0a0", "up"), "");
  ASSERT_TRUE(world_.until([&] { return !desk.received.empty(); }));
  const auto revoked = revoke(home_, "desk", now());
  ASSERT_TRUE(revoked) << revoked.error().text;
  ASSERT_THAT(*revoked, SizeIs(1));
  EXPECT_FALSE((*revoked)[0].fault);
  reload();
  ASSERT_TRUE(world_.until([&] {
    if (!desk.line || !desk.failures.empty()) return true;
    std::ignore = desk.line->publish({"rubicon-space/1/city/p/0/desk/0a0", "still here", false, 1});
    return !desk.not_taken.empty();
  })) << process_->errors();
  desk.received.clear();
  EXPECT_EQ(publish(hall, "rubicon-space/1/city/to/desk/0a0/hall/0b0", "not for desk"), "");
  EXPECT_EQ(publish(hall, "rubicon-space/1/city/p/0/hall/0b0", "nor this"), "");
  EXPECT_THAT(publish(desk, "rubicon-space/1/city/to/hall/0b0/desk/0a0", "x"), HasSubstr("to/hall"));
  EXPECT_THAT(desk.received, IsEmpty());
  EXPECT_FALSE(is_accepted(options_of(desk_place)));
  MqttClient again;
  connect(again, options_of(hall_place));
}

TEST_F(LiveBroker, AKeyThatWasReplacedOpensNoNewConnection) {
  start();
  const auto old = joined("hall");
  const auto renewed = renew(home_, "hall", 50, RenewKey::kMake, now());
  ASSERT_TRUE(renewed) << renewed.error().text;
  reload();
  EXPECT_TRUE(in_the_end([&] { return !is_accepted(options_of(old)); }));
  const fs::path folder = folder_ / "new-hall";
  ASSERT_TRUE(join_site(folder, renewed->issued.bundle, renewed->issued.phrase.view(), now()));
  MqttClient hall;
  connect(hall, options_of({folder, "hall"}));
}

TEST_F(LiveBroker, MembersWithAPasswordHaveAPortOfTheirOwn) {
  start(true);
  ASSERT_TRUE(world_.until([] { return listens(kPort + 1); }));
  const auto hall_place = joined("hall"), ann_place = joined_with_password("ann");
  reload();
  ASSERT_TRUE(in_the_end([&] { return is_accepted(options_of(ann_place)); })) << process_->errors();
  MqttClient ann, hall;
  connect(ann, options_of(ann_place));
  connect(hall, options_of(hall_place));
  subscribe(hall, "rubicon-space/1/city/to/hall/#");
  EXPECT_EQ(publish(ann, "rubicon-space/1/city/to/hall/0a0/ann/0b0", "hello"), "");
  EXPECT_NE(publish(ann, "rubicon-space/1/city/to/hall/0a0/hall/0b0", "forged"), "");
  ASSERT_TRUE(world_.until([&] { return !hall.received.empty(); }));
  auto wrong = options_of(ann_place);
  wrong.password += "x";
  EXPECT_EQ(refusal(wrong).value_or(Error{}).code, ErrorCode::kRefused);
  wrong.user = wrong.password = "";
  EXPECT_EQ(refusal(wrong).value_or(Error{}).code, ErrorCode::kRefused) << "nobody is anonymous";
  ASSERT_TRUE(revoke(home_, "ann", now()));
  reload();
  ASSERT_TRUE(world_.until([&] { return !ann.failures.empty(); })) << "its connection ends, too";
  EXPECT_EQ(refusal(options_of(ann_place)).value_or(Error{}).code, ErrorCode::kRefused);
}

TEST_F(LiveBroker, WhatIsRetainedSurvivesARestart) {
  start();
  const auto hall_place = joined("hall");
  MqttClient hall, again;
  connect(hall, options_of(hall_place));
  EXPECT_EQ(publish(hall, "rubicon-space/1/city/p/realm/hall", "kept", true), "");
  process_->signal(SIGTERM);
  EXPECT_EQ(process_->exit_code(), 0) << process_->errors();
  start();
  connect(again, options_of(hall_place));
  subscribe(again, "rubicon-space/1/city/p/#");
  ASSERT_TRUE(world_.until([&] { return !again.received.empty(); }));
  EXPECT_THAT(again.received, ElementsAre("rubicon-space/1/city/p/realm/hall kept*"));
}

TEST_F(LiveBroker, ItsFilesAreForItsUserAndAreWrittenAgain) {
  set_up(true);
  for (const auto* secret : {"broker.key", "acl", "passwords"}) {
    struct stat about {};
    ASSERT_EQ(::stat((broker_ + "/" + secret).c_str(), &about), 0) << secret;
    EXPECT_EQ(about.st_mode & 07777U, 0640U) << secret;
    EXPECT_EQ(about.st_uid, user().empty() ? ::geteuid() : service_user(user())->user) << secret;
  }
  const auto key = content_of(broker_ + "/broker.key");
  std::ofstream(broker_ + "/passwords", std::ios::app) << "bob:$7$101$AAAA$BBBB\n";
  std::ofstream(broker_ + "/conf.d/own.conf") << "max_connections 10\n";
  set_up(true);
  EXPECT_EQ(content_of(broker_ + "/broker.key"), key);
  EXPECT_THAT(content_of(broker_ + "/passwords"), HasSubstr("bob:"));
  EXPECT_EQ(content_of(broker_ + "/conf.d/own.conf"), "max_connections 10\n");
  std::ofstream(broker_ + "/passwords", std::ios::app) << "hall/c1:$7$101$AAAA$BBBB\n";
  const auto refused = set_up_mosquitto(home_, {{broker_, broker_ + "/state", user(), kPort, true}, ""}, {}, now());
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().text, HasSubstr("another level of a topic"));
  EXPECT_EQ(set_up_mosquitto(home_, {{broker_, broker_, user(), kPort, true}, ""}, {"a b"}, now()).error().code,
            ErrorCode::kInvalid);
}

}  // namespace
}  // namespace rubicon::trust::site
