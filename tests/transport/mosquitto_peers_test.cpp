#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/socket.h>
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/write.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "model/findings.h"
#include "support/private_network.h"
#include "support/process.h"
#include "transport/mqtt_client.h"
#include "transport/mqtt_exchange.h"
#include "transport/worlds.h"

namespace rubicon::transport {
namespace {

using boost::asio::ip::tcp;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using ::testing::StartsWith;

/// A server that answers each first packet of a connection in one way.
class Peer {
 public:
  /// What to send, and whether to close then; by the first packet.
  using Answer = std::function<std::pair<std::string, bool>(const std::string& packet)>;

  Peer(Loop& loop, Answer answer)
      : acceptor_(loop.context(), {boost::asio::ip::address_v4::loopback(), 0}), answer_(std::move(answer)) {
    accept();
  }
  std::uint16_t port() const { return acceptor_.local_endpoint().port(); }

  std::vector<std::string> packets;

 private:
  void accept() {
    acceptor_.async_accept([this](auto error, tcp::socket socket) {
      if (error) return;
      sockets_.push_back(std::make_unique<tcp::socket>(std::move(socket)));
      receive(*sockets_.back());
      accept();
    });
  }
  void receive(tcp::socket& socket) {
    socket.async_read_some(boost::asio::buffer(buffer_), [this, &socket](auto error, std::size_t size) {
      if (error) return;
      packets.emplace_back(buffer_.data(), size);
      const auto [bytes, closes] = answer_(packets.back());
      boost::asio::write(socket, boost::asio::buffer(bytes), error);
      if (closes) return socket.close();
      receive(socket);
    });
  }

  tcp::acceptor acceptor_;
  Answer answer_;
  std::array<char, 4096> buffer_{};
  std::vector<std::unique_ptr<tcp::socket>> sockets_;
};

/// CONNECT has the level of the protocol behind `MQTT` (MQTT 5, section 3.1.2).
char level(const std::string& packet) {
  const auto name = packet.find("MQTT");
  return name == packet.npos ? '\0' : packet[name + 4];
}

class OddPeers : public ::testing::Test {
 protected:
  MqttOptions to(const Peer& peer, MqttVersion version = MqttVersion::kAny) const {
    MqttOptions made;
    made.host = "127.0.0.1";
    made.port = peer.port();
    made.version = version;
    made.connect_time = 30s;
    return made;
  }
  Error failure(const MqttOptions& with) {
    MqttClient client;
    client.open(world.local, with);
    EXPECT_TRUE(world.until([&] { return !client.failures.empty() || client.connected > 0; }));
    EXPECT_EQ(client.connected, 0);
    return client.failures.empty() ? Error{} : client.failures[0];
  }

  MachineWorld world;
};

TEST_F(OddPeers, ABrokerOf311OnlyIsAskedAgainInItsOwnVersion) {
  Peer polite(world.loop, [](const std::string& packet) {
    if (level(packet) == 5) return std::pair(std::string("\x20\x02\x00\x01", 4), true);
    return std::pair(std::string("\x20\x02\x00\x00", 4), false);
  });
  Peer rude(world.loop, [](const std::string& packet) {
    return std::pair(level(packet) == 5 ? std::string() : std::string("\x20\x02\x00\x00", 4), level(packet) == 5);
  });
  for (auto* peer : {&polite, &rude}) {
    MqttClient client;
    client.open(world.local, to(*peer));
    ASSERT_TRUE(world.until([&] { return client.connected == 1; }));
    EXPECT_THAT(client.failures, IsEmpty());
    ASSERT_THAT(peer->packets, SizeIs(2));
    EXPECT_EQ(level(peer->packets[1]), 4);
  }
  EXPECT_FALSE(failure(to(polite, MqttVersion::k5)).text.empty());
}

TEST_F(OddPeers, AModernRefusalOfVersion5IsUnderstoodToo) {
  Peer peer(world.loop, [](const std::string& packet) {
    if (level(packet) == 5) return std::pair(std::string("\x20\x03\x00\x84\x00", 5), true);
    return std::pair(std::string("\x20\x02\x00\x00", 4), false);
  });
  MqttClient client;
  client.open(world.local, to(peer));
  EXPECT_TRUE(world.until([&] { return client.connected == 1; }));
  const auto why = failure(to(peer, MqttVersion::k5));
  EXPECT_EQ(why.code, ErrorCode::kRefused);
  EXPECT_THAT(why.text, HasSubstr("does not speak this version"));
}

TEST_F(OddPeers, RefusalsAreDistinguished) {
  const auto refused = [&](char code) {
    Peer peer(world.loop, [code](const auto&) { return std::pair(std::string("\x20\x02\x00", 3) + code, true); });
    return failure(to(peer, MqttVersion::k311));
  };
  EXPECT_THAT(refused('\x02').text, HasSubstr("refuses the client id"));
  EXPECT_THAT(refused('\x04').text, HasSubstr("refuses the user or the password"));
  EXPECT_THAT(refused('\x05').text, HasSubstr("not authorised"));
  const auto away = refused('\x03');
  EXPECT_EQ(away.code, ErrorCode::kUnreachable);
  EXPECT_THAT(away.text, HasSubstr("is not available"));
}

TEST_F(OddPeers, ASilentServerIsGivenUp) {
  Peer mute(world.loop, [](const auto&) { return std::pair(std::string(), false); });
  auto with = to(mute);
  with.connect_time = 300ms;
  const auto why = failure(with);
  EXPECT_EQ(why.code, ErrorCode::kUnreachable);
  EXPECT_THAT(why.text, HasSubstr("within 0.3 s"));
  with.tls = MqttTls{};
  EXPECT_THAT(failure(with).text, HasSubstr("within 0.3 s")) << "nor in the handshake of TLS";
}

TEST_F(OddPeers, WhoSpeaksAnotherProtocolIsRefused) {
  Peer web(world.loop, [](const auto&) { return std::pair(std::string("HTTP/1.1 400 Bad Request\r\n\r\n"), true); });
  EXPECT_THAT(failure(to(web)).text, HasSubstr("MQTT 127.0.0.1:"));
  auto with = to(web);
  with.tls = MqttTls{};
  EXPECT_THAT(failure(with).text, HasSubstr("TLS failed: wrong version number"));
  EXPECT_EQ(failure(with).finding, model::findings::kTlsFailed);
}

TEST_F(OddPeers, TheReasonOfTheBrokerForTheEndIsReported) {
  // CONNACK of version 5, then DISCONNECT with `session taken over`.
  Peer peer(world.loop,
            [](const auto&) { return std::pair(std::string("\x20\x03\x00\x00\x00\xe0\x02\x8e\x00", 9), false); });
  MqttClient client;
  client.open(world.local, to(peer));
  ASSERT_TRUE(world.until([&] { return !client.failures.empty(); }));
  EXPECT_EQ(client.connected, 1);
  EXPECT_EQ(client.failures[0].code, ErrorCode::kDuplicate);
  EXPECT_THAT(client.failures[0].text, HasSubstr("another client with the same client id"));
}

/// mosquitto drops its answers for a client that did not read: without this its publications would wait for ever.
TEST_F(OddPeers, AnAnswerThatNeverComesEndsTheLine) {
  Peer peer(world.loop, [](const std::string& packet) {
    if (level(packet) == 5) return std::pair(std::string("\x20\x03\x00\x00\x00", 5), false);
    return std::pair(packet.ends_with(std::string("\xc0\x00", 2)) ? std::string("\xd0\x00", 2) : std::string(), false);
  });
  auto with = to(peer);
  with.keep_alive = 5s;
  MqttClient subscriber, publisher, other;
  for (auto* client : {&subscriber, &publisher, &other}) {
    client->open(world.local, with);
    ASSERT_TRUE(world.until([&] { return client->connected == 1; }));
  }
  ASSERT_TRUE(subscriber.line->subscribe("a"));
  ASSERT_TRUE(publisher.line->publish({"a", "1", false, 1}));
  ASSERT_TRUE(other.line->publish({"a", "1"}));
  ASSERT_TRUE(world.until([&] { return !subscriber.failures.empty() && !publisher.failures.empty(); }));
  EXPECT_THAT(subscriber.failures[0].text, HasSubstr("the broker does not answer a subscription"));
  EXPECT_THAT(publisher.failures[0].text, HasSubstr("the broker does not answer a publication"));
  EXPECT_THAT(other.failures, IsEmpty()) << "pings are answered";
}

TEST_F(OddPeers, WrongOptionsAndUnknownHostsAreReported) {
  MqttOptions with;
  EXPECT_EQ(world.local.open_mqtt(with, {}).error().code, ErrorCode::kInvalid) << "no host";
  with.host = "no-such-host.invalid";
  const auto why = failure(with);
  EXPECT_EQ(why.code, ErrorCode::kUnreachable);
  EXPECT_THAT(why.text, HasSubstr("host no-such-host.invalid cannot be found"));
  EXPECT_EQ(why.finding, model::findings::kHostUnknown);
}

TEST_F(OddPeers, ALineMayEndBeforeItIsConnected) {
  Peer mute(world.loop, [](const auto&) { return std::pair(std::string(), false); });
  for (int i = 0; i < 20; ++i) {
    MqttClient client;
    client.open(world.local, to(mute));
    if (i % 2 == 0) continue;
    ASSERT_TRUE(world.until([&] { return mute.packets.size() >= static_cast<std::size_t>(i / 2) + 1; }));
  }
}

constexpr auto kResolver = "RUBICON_TEST_RESOLVER";

/// For the rest of this process; empty, or why not.
std::string ask_a_mute_name_server(const std::string& resolver, int server) {
  if (::unshare(CLONE_NEWNS) != 0 || ::mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0 ||
      ::mount(resolver.c_str(), "/etc/resolv.conf", nullptr, MS_BIND, nullptr) != 0)
    return "may not have an /etc/resolv.conf of its own here";
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(53);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const bool bound = ::bind(server, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  return bound ? "" : "no port of a name server";
}

/// In a process of its own, whose threads still wait for the name server when it ends.
void open_a_line_by_a_mute_name_server(const std::string& resolver) {
  const support::PrivateNetwork network;
  if (!network.entered()) GTEST_SKIP() << network.reason();
  const int server = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (const auto why = ask_a_mute_name_server(resolver, server); !why.empty()) GTEST_SKIP() << why;
  MachineWorld world;
  MqttClient client;
  MqttOptions options;
  options.host = "broker.example.com";
  options.connect_time = 300ms;
  client.open(world.local, options);
  char question = 0;
  EXPECT_TRUE(world.until([&] { return ::recv(server, &question, 1, MSG_DONTWAIT) > 0; }));
  ASSERT_TRUE(world.until([&] { return !client.failures.empty(); }));
  EXPECT_THAT(client.failures[0].text, HasSubstr("cannot be found or does not answer within 0.3 s"));
}

TEST(MuteNameServer, StopsNeitherTheLoopNorTheEndOfTheProcess) {
  if (const auto* resolver = std::getenv(kResolver)) return open_a_line_by_a_mute_name_server(resolver);
  const auto resolver = std::filesystem::temp_directory_path() / ("rubicon-resolv-" + std::to_string(::getpid()));
  std::ofstream(resolver) << "nameserver 127.0.0.1\noptions timeout:30 attempts:5\n";
  const auto child = support::run_to_end({"env", std::string(kResolver) + "=" + resolver.string(),
                                          std::filesystem::read_symlink("/proc/self/exe").string(),
                                          "--gtest_filter=MuteNameServer.*"});
  std::filesystem::remove(resolver);
  EXPECT_EQ(child.code, 0) << child.output << child.errors;
  if (child.output.find("SKIPPED") != std::string::npos) GTEST_SKIP() << child.output;
}

class Exchange : public ::testing::Test {
 protected:
  static MqttEvent event(std::size_t size) { return {MqttEvent::Kind::kReceived, "t", std::string(size, 'x')}; }

  VirtualScheduler time;
  std::shared_ptr<MqttHome> home = std::make_shared<MqttHome>(time);
  int called = 0;
  std::shared_ptr<MqttExchange> exchange = MqttExchange::make(home, "MQTT a:1883", [this] { ++called; });
};

TEST_F(Exchange, TheThreadStopsReadingWhileTheLoopHasEnough) {
  const auto quarter = MqttLine::kMaxUndelivered / 4;
  for (int i = 0; i < 4; ++i) {
    EXPECT_TRUE(exchange->may_read()) << i;
    std::vector<MqttEvent> one;
    one.push_back(event(quarter));
    exchange->tell(std::move(one));
  }
  EXPECT_FALSE(exchange->may_read());
  time.run_ready();
  EXPECT_EQ(called, 1) << "one call for all";
  const auto taken = exchange->take();
  ASSERT_THAT(taken, SizeIs(4));
  EXPECT_FALSE(exchange->may_read()) << "the loop has not delivered them yet";
  exchange->delivered(MqttExchange::cost(taken[0]));
  EXPECT_TRUE(exchange->may_read());
}

TEST_F(Exchange, FiltersGoBeforeThePublicationsThatFollowThem) {
  MqttWork work;
  ASSERT_TRUE(exchange->publish({"a", "1"}));
  ASSERT_TRUE(exchange->ask({"a", 0, true}));
  exchange->take_work(1, work);
  EXPECT_THAT(work.asks, SizeIs(1));
  EXPECT_THAT(work.publications, IsEmpty());
  exchange->take_work(std::nullopt, work);
  EXPECT_TRUE(work.empty());
  exchange->take_work(1, work);
  EXPECT_THAT(work.publications, SizeIs(1));
  exchange->take_work(1, work);
  EXPECT_TRUE(work.empty());
}

TEST_F(Exchange, FiltersThatWaitForTheBrokerAreBounded) {
  const MqttAsk large{std::string(60'000, 'a'), 0, true};
  std::size_t asked = 0;
  while (exchange->ask(large)) ++asked;
  EXPECT_EQ(asked, MqttLine::kMaxAskedBytes / MqttExchange::cost(large));
  MqttWork work;
  exchange->take_work(std::nullopt, work);
  EXPECT_THAT(work.asks, SizeIs(asked));
  EXPECT_EQ(exchange->ask(large).error().code, ErrorCode::kBusy) << "they wait for their answer";
  exchange->answered_ask(large);
  EXPECT_TRUE(exchange->ask(large));
}

/// The exchanges of lines, each with a thread.
class Threads : public Exchange {
 protected:
  Result<void> begin(const std::string& line) {
    lines.push_back(MqttExchange::make(home, line, [] {}));
    auto entered = home->enter(*lines.back());
    if (!entered) lines.pop_back();
    return entered;
  }

  std::vector<std::shared_ptr<MqttExchange>> lines;
};

TEST_F(Threads, ABrokerThatCannotBeFoundTakesNoThreadsFromOthers) {
  for (std::size_t i = 0; i < MqttHome::kMaxStuck; ++i) {
    ASSERT_TRUE(begin("MQTT mute:1883"));
    lines.back()->dismiss();
  }
  const auto refused = begin("MQTT mute:1883");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kBusy);
  EXPECT_THAT(refused.error().text, StartsWith("MQTT mute:1883: 16 earlier attempts still wait for the host"));
  EXPECT_TRUE(begin("MQTT other:1883"));
  home->leave(*lines.front());
  EXPECT_TRUE(begin("MQTT mute:1883")) << "one of them gave up";
}

TEST_F(Threads, LinesThatAreBeingClosedDoNotHinderNewOnes) {
  for (std::size_t i = 0; i < 2 * MqttHome::kMaxStuck; ++i) {
    ASSERT_TRUE(begin("MQTT a:1883"));
    lines.back()->answered = true;
    lines.back()->dismiss();
  }
  EXPECT_TRUE(begin("MQTT a:1883"));
}

TEST_F(Threads, TheConnectionsOfAProcessAreBounded) {
  for (std::size_t i = 0; i < MqttHome::kMaxThreads; ++i) ASSERT_TRUE(begin("MQTT a:1883"));
  const auto refused = begin("MQTT b:1883");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kBusy);
  EXPECT_THAT(refused.error().text, StartsWith("MQTT b:1883: 256 connections to MQTT brokers are open"));
}

TEST_F(Exchange, NothingIsPostedToALoopThatEnded) {
  home->close(0s);
  std::vector<MqttEvent> one;
  one.push_back(event(1));
  exchange->tell(std::move(one));
  time.run_ready();
  EXPECT_EQ(called, 0);
}

}  // namespace
}  // namespace rubicon::transport
