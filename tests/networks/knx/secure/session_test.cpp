#include "networks/knx/secure/session.h"

#include <map>
#include <optional>

#include "networks/knx/secure/session_fixture.h"

namespace rubicon::networks::knx::secure {
namespace {

/// The server of the worked vectors: session 1, private key 21 22 ...
class SessionTest : public SessionFixture {
 protected:
  SessionTest() : server(KeyPair::of(counting(0x21)).value()) { give_random(counting(0x01), hex("00fa12345678")); }

  Bytes response(std::uint16_t id = 1, const Key& code = key_of("e158e4012047bd6cc41aafbc5c04c1fc")) {
    const auto client = KeyPair::of(counting(0x01)).value().public_key();
    channel.emplace(id, session_key(server.shared_with(client).value()).value(), serial);
    return write(
        SessionResponse{id, server.public_key(), response_mac(ccm, code, id, client, server.public_key()).value()});
  }
  /// The server wraps a frame.
  Bytes wrapped(const Bytes& plain) {
    const auto bytes = channel->seal(ccm, plain).value();
    return {bytes.begin(), bytes.end()};
  }
  void connect() {
    start();
    session->receive(response());
    session->receive(wrapped(write(Status::kAuthenticated)));
    ASSERT_EQ(ups, 1);
  }
  /// The plain content of the last frame that the client sent.
  Bytes last_plain() {
    const auto wrapper = read_wrapper(wire::read_frame(sent.back()).value()).value();
    SessionChannel reader(1, session_key(server.shared_with(KeyPair::of(counting(0x01))->public_key()).value()).value(),
                          {});
    EXPECT_EQ(reader.open(ccm, wrapper).value(), SessionChannel::Verdict::kFrame);
    return {reader.opened().begin(), reader.opened().end()};
  }
  Session::End only_end() {
    EXPECT_EQ(ends.size(), 1U);
    return ends.empty() ? Session::End{} : ends.front();
  }

  KeyPair server;
  Serial serial{0xba, 0x4d, 0xab, 0x01, 0x47, 0x8f};
  Ccm ccm;
  std::optional<SessionChannel> channel;
};

TEST_F(SessionTest, TheHandshakeOfTheWorkedVectors) {
  start();
  EXPECT_EQ(last_sent(),
            "06100951002e080200000000000007a37cbc142093c8b755dc1b10e86cb426374ad16aa853ed0bdfc0b2b86d1c7c");
  EXPECT_EQ(
      base::to_hex(response()),
      "06100952003800015869aff450549732cbaaed5e5df9b30a6da31cb0e5742bad5ad4a1a768f1a67bcb2caafaa6eb7d18b8a361a7b39"
      "bbaf7");
  session->receive(response());
  EXPECT_EQ(
      last_sent(),
      "06100950003e000100000000000000fa123456780000c7ccb27b58d90bc60767fdf6f891194138365f4db8968d82efb830361abb515"
      "889d5b1383a441c95");
  session->receive(wrapped(write(Status::kAuthenticated)));
  EXPECT_TRUE(session->up());
  EXPECT_TRUE(session->verified());
  session->send(hex("06100205001a0802000000000000080200000000000004040200"));
  EXPECT_EQ(
      last_sent(),
      "061009500040000100000000000100fa123456780000ca7fb2357ceabf444af7fe18eb9399ce9e737721c2983566a58299adaf1e8d3"
      "d1623bc33f45dc78045f4");
  time.run_for(50s);
  EXPECT_EQ(last_sent(),
            "06100950002e000100000000000200fa123456780000db38a0ab22281b5052794b7fbdb69eb924d36cf811a836ad");
  session->close();
  EXPECT_EQ(last_sent(),
            "06100950002e000100000000000300fa123456780000c9ae60e57cc38d5795af33dd59f6bcde7d7c1e03b01290ac");
  EXPECT_EQ(sent.size(), 5U);
  EXPECT_TRUE(ends.empty());
}

TEST_F(SessionTest, ThePlainFramesOfTheServerArriveInOrder) {
  connect();
  for (std::uint8_t i = 0; i < 10; ++i) session->receive(wrapped(hex("0610042000080" + std::to_string(i) + "00")));
  ASSERT_EQ(received.size(), 10U);
  EXPECT_EQ(base::to_hex(received[7]), "0610042000080700");
  EXPECT_TRUE(notes.empty());
}

TEST_F(SessionTest, EachConnectionHasAKeyPairOfItsOwn) {
  start();
  give_random(counting(0x41), hex("00fa12345678"));
  start();
  ASSERT_EQ(sent.size(), 2U);
  EXPECT_NE(sent[0], sent[1]);
}

TEST_F(SessionTest, NoKeyPairWithoutRandomBytes) {
  random_bytes.clear();
  start();
  EXPECT_EQ(only_end().cause, Session::Cause::kBroken);
  EXPECT_TRUE(sent.empty());
}

TEST_F(SessionTest, AServerWithAnotherDevicePasswordGetsNothingAndIsNamed) {
  start();
  session->receive(response(1, key_of("602ca362884fa245e39b26917d3cac34")));
  EXPECT_EQ(only_end().cause, Session::Cause::kWrongServer);
  EXPECT_NE(only_end().why.find("is not the device"), std::string::npos);
  EXPECT_EQ(sent.size(), 1U);
}

TEST_F(SessionTest, ADevicePasswordBeyondAsciiMayBeThatOfTheReplacement) {
  keys.device_code = PasswordKey{key_of("602ca362884fa245e39b26917d3cac34"), {keys.device_code->key}};
  connect();
  EXPECT_TRUE(session->verified());
}

TEST_F(SessionTest, WithoutADevicePasswordTheServerCountsAsNotVerified) {
  keys.device_code.reset();
  start();
  session->receive(response(1, key_of("602ca362884fa245e39b26917d3cac34")));
  session->receive(wrapped(write(Status::kAuthenticated)));
  EXPECT_TRUE(session->up());
  EXPECT_FALSE(session->verified());
  EXPECT_EQ(counters.unverified, 1U);
}

/// Over UDP anybody can send a datagram in the server's name.
TEST_F(SessionTest, OverUdpAForgedResponseDoesNotEndTheHandshake) {
  const auto low_order = write(SessionResponse{1, PublicKey{}, Block{}});
  for (const auto& forged : {response(1, key_of("602ca362884fa245e39b26917d3cac34")), response(0), low_order}) {
    ups = 0;
    settings.repeats = true;
    give_random(counting(0x01), hex("00fa12345678"));
    start();
    session->receive(forged);
    session->receive(response());
    session->receive(wrapped(write(Status::kAuthenticated)));
    EXPECT_EQ(ups, 1);
  }
  EXPECT_TRUE(ends.empty());
  EXPECT_EQ(counters.wrong_mac, 2U);
}

TEST_F(SessionTest, OverUdpARefusalIsNamedWhenNoBetterResponseComes) {
  const std::map<Session::Cause, Bytes> refusals{
      {Session::Cause::kWrongServer, response(1, key_of("602ca362884fa245e39b26917d3cac34"))},
      {Session::Cause::kNoneFree, response(0)}};
  for (const auto& [cause, refusal] : refusals) {
    ends.clear();
    settings.repeats = true;
    give_random(counting(0x01), hex("00fa12345678"));
    start();
    session->receive(refusal);
    time.run_for(9900ms);
    EXPECT_TRUE(ends.empty());
    time.run_for(100ms);
    EXPECT_EQ(only_end().cause, cause);
  }
}

TEST_F(SessionTest, TheOtherFormOfThePasswordIsUsedWhenAsked) {
  keys.user_key = {key_of("e158e4012047bd6cc41aafbc5c04c1fc"), std::vector{keys.user_key.key}};
  settings.password_form = 1;
  start();
  session->receive(response());
  EXPECT_EQ(last_sent().substr(44, 12), "c7ccb27b58d9");
  EXPECT_EQ(last_sent().substr(last_sent().size() - 8), "3a441c95");
}

TEST_F(SessionTest, SessionZeroMeansThatNoneIsFree) {
  for (const auto& refusal : {response(0), hex("0610095200080000")}) {
    ends.clear();
    give_random(counting(0x01), hex("00fa12345678"));
    start();
    session->receive(refusal);
    EXPECT_EQ(only_end().cause, Session::Cause::kNoneFree);
  }
}

TEST_F(SessionTest, StatusOneAndTwoAreAWrongUserOrPassword) {
  for (const auto status : {Status::kAuthenticationFailed, Status::kUnauthenticated}) {
    ends.clear();
    give_random(counting(0x01), hex("00fa12345678"));
    start();
    session->receive(response());
    session->receive(wrapped(write(status)));
    EXPECT_EQ(only_end().cause, Session::Cause::kNotAuthenticated);
    EXPECT_EQ(only_end().status, static_cast<std::uint8_t>(status));
    EXPECT_NE(only_end().why.find("user 2"), std::string::npos);
    EXPECT_EQ(last_plain(), write(Status::kClose));
  }
}

TEST_F(SessionTest, LaterStatusesEndTheSession) {
  const std::map<Status, Session::Cause> causes{{Status::kAuthenticationFailed, Session::Cause::kForgotten},
                                                {Status::kUnauthenticated, Session::Cause::kForgotten},
                                                {Status::kTimeout, Session::Cause::kClosed},
                                                {Status::kClose, Session::Cause::kClosed}};
  for (const auto& [status, cause] : causes) {
    ends.clear();
    ups = 0;
    give_random(counting(0x01), hex("00fa12345678"));
    connect();
    session->receive(wrapped(write(status)));
    EXPECT_EQ(only_end().cause, cause);
    EXPECT_FALSE(session->up());
  }
}

TEST_F(SessionTest, KeepAliveAndUnknownStatusesOfTheServerAreIgnored) {
  connect();
  for (const auto status : {Status::kAuthenticated, Status::kKeepAlive}) session->receive(wrapped(write(status)));
  EXPECT_TRUE(notes.empty());
  for (const auto status : {Status(6), Status(0xff)}) session->receive(wrapped(write(status)));
  EXPECT_EQ(counters.bad_frames, 2U);
  ASSERT_EQ(notes.size(), 2U);
  EXPECT_NE(notes[1].find("session status 255"), std::string::npos) << notes[1];
  EXPECT_TRUE(session->up());
  EXPECT_EQ(ups, 1);
  EXPECT_TRUE(ends.empty());
}

TEST_F(SessionTest, FramesBeforeTheAuthenticationAreDropped) {
  start();
  session->receive(response());
  session->receive(wrapped(hex("061002060014010008020000000000000404110a")));
  EXPECT_EQ(counters.early_frames, 1U);
  EXPECT_TRUE(received.empty());
}

TEST_F(SessionTest, PlainFramesAreDroppedInEveryState) {
  start();
  session->receive(hex("061002060014010008020000000000000404110a"));
  session->receive(response());
  session->receive(hex("0610095400080000"));  // plain status: authenticated
  EXPECT_EQ(ups, 0);
  session->receive(wrapped(write(Status::kAuthenticated)));
  session->receive(hex("06100209001001000802000000000000"));  // plain DISCONNECT_REQUEST
  session->receive(hex("0610095400080500"));                  // plain status: close
  session->receive(response(2));
  EXPECT_TRUE(session->up());
  EXPECT_TRUE(received.empty());
  EXPECT_EQ(counters.plain_frames, 5U);
  ASSERT_FALSE(notes.empty());
  EXPECT_EQ(notes.front().substr(0, 20), "secure-plain-frames:");
}

TEST_F(SessionTest, ReplaysReflectionsAndChangedFramesAreDropped) {
  connect();
  const auto first = wrapped(hex("0610020800080100")), second = wrapped(hex("0610020a00080100"));
  session->receive(second);
  session->receive(second);
  session->receive(first);
  EXPECT_EQ(counters.replays, 2U);
  session->receive(sent.back());  // our own authentication
  EXPECT_EQ(counters.replays, 3U);
  auto changed = wrapped(hex("0610020800080100"));
  changed.back() ^= 1U;
  session->receive(changed);
  EXPECT_EQ(counters.wrong_mac, 1U);
  changed.back() ^= 1U;
  session->receive(changed);  // the number was not spent by the wrong MAC
  EXPECT_EQ(received.size(), 2U);
  auto other = wrapped(hex("0610020800080100"));
  other[7] = 9;
  session->receive(other);
  EXPECT_EQ(counters.other_sessions, 1U);
  EXPECT_TRUE(session->up());
}

TEST_F(SessionTest, AWrapperHoldsNoWrapperNoDiagnosisAndNoHandshake) {
  connect();
  const auto inner = wrapped(hex("0610020800080100"));
  for (const auto& content :
       {inner, hex("061007400006"), hex("061007430006"), hex("0610"), Bytes(), write(SessionRequest{}),
        write(SessionResponse{}), write(SessionAuthenticate{}), write(TimerNotify{}), hex("06100208000801")})
    session->receive(wrapped(content));
  EXPECT_EQ(counters.forbidden_frames, 10U);
  EXPECT_TRUE(received.empty());
  EXPECT_TRUE(session->up());
}

TEST_F(SessionTest, BrokenFramesAreCounted) {
  start();
  session->receive(hex("0610095200070000"));
  session->receive(hex("06100952000700"));
  EXPECT_EQ(counters.bad_frames, 2U);
  session->receive(response());
  session->receive(hex("0610095000080001"));
  EXPECT_EQ(counters.bad_frames, 3U);
  session->receive(
      wrapped(hex("061009540007"
                  "00")));
  EXPECT_EQ(counters.bad_frames, 4U);
  EXPECT_TRUE(ends.empty());
}

TEST_F(SessionTest, AUselessPublicKeyOfTheServerEndsTheSession) {
  keys.device_code.reset();
  start();
  session->receive(write(SessionResponse{1, PublicKey{}, Block{}}));
  EXPECT_EQ(only_end().cause, Session::Cause::kBroken);
  EXPECT_EQ(sent.size(), 1U);
}

TEST_F(SessionTest, TheHandshakeTakesTenSecondsAtMost) {
  start();
  time.run_for(9900ms);
  EXPECT_TRUE(ends.empty());
  session->receive(response());
  time.run_for(99ms);
  EXPECT_TRUE(ends.empty());
  time.run_for(1ms);
  EXPECT_EQ(only_end().cause, Session::Cause::kNoAnswer);
  EXPECT_EQ(sent.size(), 2U);
}

TEST_F(SessionTest, OverUdpRequestsAreRepeated) {
  settings.repeats = true;
  settings.own = wire::udp_hpai("10.0.0.2", 40000);
  settings.tries_route_back = true;
  start();
  EXPECT_EQ(last_sent().substr(12, 16), "08010a0000029c40");
  time.run_for(2s);
  ASSERT_EQ(sent.size(), 2U);
  EXPECT_EQ(last_sent().substr(12, 16), "0801000000000000");
  EXPECT_TRUE(session->own().route_back());
  session->receive(response());
  time.run_for(4s);
  ASSERT_EQ(sent.size(), 5U);
  EXPECT_NE(sent[3], sent[4]) << "each repeat has a sequence number of its own";
  session->receive(wrapped(write(Status::kAuthenticated)));
  session->receive(wrapped(write(Status::kAuthenticated)));
  EXPECT_EQ(ups, 1);
}

TEST_F(SessionTest, KeepAliveOnlyAfterFiftySecondsWithoutAFrameOfOurs) {
  connect();
  for (int i = 0; i < 10; ++i) {
    time.run_for(49s);
    session->receive(wrapped(hex("0610020800080100")));
    session->send(hex("06100207001001000802000000000000"));
  }
  EXPECT_EQ(sent.size(), 12U);
  time.run_for(150s);
  EXPECT_EQ(sent.size(), 15U);
  EXPECT_EQ(last_plain(), write(Status::kKeepAlive));
}

TEST_F(SessionTest, OverUdpAKeepAliveMayBeLostTwice) {
  settings.repeats = true;
  connect();
  const auto before = sent.size();
  time.run_for(59s);
  EXPECT_EQ(sent.size(), before + 3);
  EXPECT_EQ(last_plain(), write(Status::kKeepAlive));
}

TEST_F(SessionTest, CloseIsSentFromTheAuthenticationOnAndOnce) {
  start();
  session->close();
  EXPECT_EQ(sent.size(), 1U);
  give_random(counting(0x01), hex("00fa12345678"));
  start();
  session->receive(response());
  session->close();
  EXPECT_EQ(last_plain(), write(Status::kClose));
  const auto count = sent.size();
  session->close();
  session->receive(wrapped(write(Status::kAuthenticated)));
  time.run_for(100s);
  EXPECT_EQ(sent.size(), count);
  EXPECT_TRUE(ends.empty());
}

TEST_F(SessionTest, MayBeDestroyedInItsCallbacks) {
  Session::Callbacks calls;
  calls.transmit = [](ByteView) {};
  calls.up = [this] { session.reset(); };
  calls.ended = [this](Session::End) { session.reset(); };
  settings.random = system_random();
  session = std::make_unique<Session>(time, keys, settings, counters, calls);
  session->start();
  session->receive(write(SessionResponse{}));
  EXPECT_EQ(session, nullptr);
  session = std::make_unique<Session>(time, keys, settings, counters, calls);
  session->start();
  time.run_for(20s);
  EXPECT_EQ(session, nullptr);
}

}  // namespace
}  // namespace rubicon::networks::knx::secure
