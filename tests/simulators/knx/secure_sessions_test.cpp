#include "apps/simulators/knx/secure_sessions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/virtual_scheduler.h"
#include "networks/knx/secure/session.h"

namespace rubicon::knx_simulator {
namespace {

using namespace std::chrono_literals;
using namespace networks::knx::secure;
using networks::knx::wire::read_frame;
using networks::knx::wire::ServiceCode;
using ::testing::HasSubstr;

Key key_from(std::uint8_t first) {
  Key key;
  for (auto& byte : key.span()) byte = first++;
  return key;
}

/// The sessions of a server and clients of them, without sockets.
class SecureSessionsTest : public testing::Test {
 protected:
  struct Client {
    std::unique_ptr<Session> session;
    std::vector<Bytes> sent;
    std::vector<std::string> ends;
    bool up = false;
  };

  SecureSessionsTest() {
    options.device_code = key_from(1);
    options.users = {{2, key_from(2), 0}};
    options.sessions = 3;
  }
  void start() {
    server = std::make_unique<SecureSessions>(time, options, [this](std::uint16_t id) { ended.push_back(id); });
  }
  std::unique_ptr<Client> make_client(const void* connection = nullptr) {
    auto client = std::make_unique<Client>();
    Session::Callbacks calls;
    calls.transmit = [this, one = client.get(), connection](ByteView bytes) {
      one->sent.emplace_back(bytes.begin(), bytes.end());
      const Bytes copy = one->sent.back();
      time.post([this, one, copy, connection] { deliver(*one, copy, connection); });
    };
    calls.up = [one = client.get()] { one->up = true; };
    calls.received = [](ByteView) {};
    calls.ended = [one = client.get()](Session::End end) { one->ends.push_back(std::move(end.why)); };
    client->session = std::make_unique<Session>(time, keys, Session::Settings{}, counters, std::move(calls));
    client->session->start();
    time.run_for(1ms);
    return client;
  }
  void deliver(Client& client, const Bytes& bytes, const void* connection) {
    const auto frame = read_frame(bytes).value();
    if (frame.service == ServiceCode::kSecureWrapper) {
      if (auto opened = server->unwrap(frame)) taken.push_back(std::move(*opened));
      return;
    }
    const auto reply = [this, &client](ByteView answer) {
      time.post([&client, copy = Bytes(answer.begin(), answer.end())] {
        if (client.session) client.session->receive(copy);
      });
    };
    server->request(frame, reply, connection);
  }

  VirtualScheduler time;
  SecureOptions options;
  SessionKeys keys{2, {key_from(2), {}}, PasswordKey{key_from(1), {}}};
  SessionCounters counters;
  std::unique_ptr<SecureSessions> server;
  std::vector<std::uint16_t> ended;
  std::vector<SecureSessions::Opened> taken;
};

TEST_F(SecureSessionsTest, FramesOfAnAuthenticatedClientAreTaken) {
  start();
  const auto client = make_client();
  ASSERT_TRUE(client->up);
  ASSERT_NE(server->user_of(1), nullptr);
  EXPECT_EQ(server->user_of(1)->number, 2);
  client->session->send(*base::from_hex("06100207001001000802000000000000"));
  time.run_for(1ms);
  ASSERT_EQ(taken.size(), 1U);
  EXPECT_EQ(taken[0].session, 1);
  EXPECT_EQ(base::to_hex(taken[0].frame), "06100207001001000802000000000000");
}

TEST_F(SecureSessionsTest, AReplayedFrameIsTakenOnce) {
  start();
  const auto client = make_client();
  client->session->send(*base::from_hex("06100207001001000802000000000000"));
  const auto again = client->sent.back();
  time.run_for(1ms);
  deliver(*client, again, nullptr);
  auto changed = again;
  changed[8 + 5] = 9;  // a sequence number that is still to come
  deliver(*client, changed, nullptr);
  EXPECT_EQ(taken.size(), 1U);
  EXPECT_EQ(server->counters.replays, 1U);
  EXPECT_EQ(server->counters.wrong_mac, 1U);
}

TEST_F(SecureSessionsTest, ASessionThatIsNeverAuthenticatedEndsAfterTenSeconds) {
  start();
  server->answers_authentication = false;
  const auto client = make_client();
  EXPECT_EQ(server->size(), 1U);
  time.run_for(9s);
  EXPECT_EQ(server->size(), 1U);
  time.run_for(1s);
  EXPECT_EQ(server->size(), 0U);
  EXPECT_EQ(ended, std::vector<std::uint16_t>{1});
}

TEST_F(SecureSessionsTest, ASilentSessionEndsAfterAMinute) {
  start();
  const auto client = make_client();
  client->session.reset();  // nothing is sent any longer
  time.run_for(59s);
  EXPECT_EQ(server->size(), 1U);
  time.run_for(1s);
  EXPECT_EQ(server->size(), 0U);
  EXPECT_EQ(server->counters.timeouts, 1U);
}

TEST_F(SecureSessionsTest, TheFourthClientOfThreeIsRefusedAndALostConnectionMakesRoom) {
  start();
  const int connection = 0;
  std::vector<std::unique_ptr<Client>> clients;
  for (int i = 0; i < 4; ++i) clients.push_back(make_client(i == 0 ? &connection : nullptr));
  EXPECT_TRUE(clients[2]->up);
  ASSERT_EQ(clients[3]->ends.size(), 1U);
  EXPECT_THAT(clients[3]->ends[0], HasSubstr("all secure sessions"));
  server->lose(&connection);
  EXPECT_EQ(server->size(), 2U);
  EXPECT_TRUE(make_client()->up);
}

TEST(SecureOptions, PasswordsReachToTheEndOfTheirLine) {
  const auto options =
      parse_secure_options("# test\n\ndevice-password trustme\nuser 2 any user2pw\nuser 3 1.1.201 a b");
  ASSERT_TRUE(options) << options.error().text;
  EXPECT_EQ(base::to_hex(options->device_code.view()), "e158e4012047bd6cc41aafbc5c04c1fc");
  ASSERT_EQ(options->users.size(), 2U);
  EXPECT_EQ(base::to_hex(options->users[0].key.view()), "43e24ee1095ee6e9483baa42598b4aba");
  EXPECT_EQ(options->users[0].address, 0);
  EXPECT_EQ(options->users[1].number, 3);
  EXPECT_EQ(options->users[1].address, 0x11c9);
}

TEST(SecureOptions, EveryMistakeIsNamedWithItsLineAndWithoutPasswords) {
  const std::pair<const char*, const char*> mistakes[] = {
      {"", "expected a line `user"},
      {"device-password x", "expected a line `user"},
      {"user 2 any x\npassword y", "line 2: expected `device-password"},
      {"user 0 any hidden", "line 1: expected a user number"},
      {"user 128 any hidden", "line 1: expected a user number"},
      {"user 2 hidden", "line 1: expected `any` or an address"},
      {"user 2 any hidden\xff", "line 1: the password is not UTF-8"},
  };
  for (const auto& [text, expected] : mistakes) {
    const auto options = parse_secure_options(text);
    ASSERT_FALSE(options) << text;
    EXPECT_THAT(options.error().text, HasSubstr(expected));
    EXPECT_EQ(options.error().text.find("hidden"), std::string::npos);
  }
}

}  // namespace
}  // namespace rubicon::knx_simulator
