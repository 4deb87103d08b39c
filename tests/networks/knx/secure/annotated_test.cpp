#include "networks/knx/secure/annotated.h"

#include <gtest/gtest.h>

#include <map>
#include <optional>
#include <set>

#include "networks/knx/secure/session_fixture.h"

// Every row of the annotated sessions of two clients and a server (../shared/data/knx-secure/README.md).

namespace rubicon::networks::knx::secure {
namespace {

using wire::ServiceCode;

constexpr std::string_view kMissing = "no ../shared/data/knx-secure beside the source tree";

Wrapper wrapper_of(const Bytes& frame) {
  return read_wrapper(wire::read_frame(frame).value()).value();
}

bool is_wrapper(const Bytes& frame) {
  return wire::read_frame(frame).value().service == ServiceCode::kSecureWrapper;
}

std::string place(const AnnotatedSession& session, const AnnotatedRow& row) {
  return session.file + " at " + std::to_string(row.seconds) + " " + row.direction + " " + row.note;
}

/// One of the intermediate values: keys, both handshake MACs.
void expect_keys(const AnnotatedSession& session) {
  const auto pair = KeyPair::of(Secret(hex(session.keys.at("client private key")))).value();
  for (const auto& row : session.rows) {
    const auto frame = wire::read_frame(row.frame).value();
    if (frame.service != ServiceCode::kSessionResponse) continue;
    const auto response = read_session_response(frame).value();
    const auto shared = pair.shared_with(response.public_key).value();
    const auto key = session_key(shared).value();
    EXPECT_EQ(base::to_hex(key.view()), session.keys.at("session key")) << session.file;
    EXPECT_EQ(write(response), row.frame);
    if (!session.has("client public key")) continue;
    EXPECT_EQ(base::to_hex(pair.public_key()), session.keys.at("client public key"));
    EXPECT_EQ(base::to_hex(shared.view()), session.keys.at("shared secret"));
    Ccm ccm;
    const auto code = key_of(session.keys.at("device authentication code"));
    const auto mac = response_mac(ccm, code, response.session, pair.public_key(), response.public_key).value();
    EXPECT_EQ(mac == response.mac, session.file != "wrong-device-password") << session.file;
  }
}

TEST(AnnotatedSessions, KeysAndMacsOfAllHandshakes) {
  const auto sessions = annotated_sessions();
  if (sessions.empty()) GTEST_SKIP() << kMissing;
  std::size_t handshakes = 0;
  for (const auto& session : sessions) {
    if (!session.has("client private key")) continue;
    expect_keys(session);
    ++handshakes;
  }
  EXPECT_EQ(handshakes, 17U);
}

TEST(AnnotatedSessions, PasswordsOfTheSessionsGiveTheirKeys) {
  const auto sessions = annotated_sessions();
  if (sessions.empty()) GTEST_SKIP() << kMissing;
  const auto expect = [](const Result<PasswordKey>& made, const std::string& text) {
    EXPECT_EQ(base::to_hex(made->key.view()), text);
  };
  expect(device_code(Secret::of_text("auth-code-give")), "9216fa59d4baa6a78cc0aa1ecfbdf5a6");
  expect(device_code(Secret::of_text("other device")), "602ca362884fa245e39b26917d3cac34");
  expect(user_key(Secret::of_text("tunnel two")), "feffdd26a166bd804f1331bd86513d1a");
  expect(user_key(Secret::of_text("tunnel three!")), "3209c23dc504344375fda44f9ede708c");
  expect(user_key(Secret::of_text("not the password")), "7c7642377f854a63a8a76914fe5d72cf");
}

/// The recorded line whose MAC was changed on purpose.
bool tampered(const AnnotatedRow& row) {
  return row.note == "MAC changed";
}

TEST(AnnotatedSessions, EveryWrapperIsOpenedAndMadeAgainByteForByte) {
  const auto sessions = annotated_sessions();
  if (sessions.empty()) GTEST_SKIP() << kMissing;
  Ccm ccm;
  std::size_t wrappers = 0, bad = 0;
  for (const auto& session : sessions) {
    for (const auto& row : session.rows) {
      if (!is_wrapper(row.frame)) continue;
      ++wrappers;
      const auto key = key_of(session.keys.at("session key"));
      const auto wrapper = wrapper_of(row.frame);
      Bytes plain, again;
      const auto opened = open_wrapper(ccm, key, wrapper, plain).value();
      const bool nested = !tampered(row) && wire::read_frame(row.plain)->service == ServiceCode::kSecureWrapper;
      const auto expected = tampered(row) ? Opened::kWrongMac : nested ? Opened::kForbidden : Opened::kFrame;
      EXPECT_EQ(opened, expected) << place(session, row);
      bad += tampered(row) ? 1U : 0U;
      EXPECT_EQ(plain, opened == Opened::kFrame ? row.plain : Bytes()) << place(session, row);
      if (tampered(row)) continue;
      ASSERT_TRUE(seal_wrapper(ccm, key, wrapper.head, row.plain, again));
      EXPECT_EQ(again, row.frame) << place(session, row);
      const auto mac =
          ccm.mac(key, nonce_of(wrapper.head, row.plain.size()).b0, ByteView(row.frame).first(8), row.plain);
      EXPECT_EQ(base::to_hex(*mac), row.mac_cbc) << place(session, row);
    }
  }
  EXPECT_EQ(wrappers, 199U);
  EXPECT_EQ(bad, 1U);
}

/// What a strict server says about each frame of a client. The recorded server is laxer (knx.md, section 21.2).
std::optional<std::string> strict_reason(const AnnotatedSession& session, SessionChannel& server, Ccm& ccm,
                                         const AnnotatedRow& row) {
  if (!is_wrapper(row.frame)) return "plain";
  switch (server.open(ccm, wrapper_of(row.frame)).value()) {
    case SessionChannel::Verdict::kFrame: EXPECT_EQ(base::to_hex(server.opened()), base::to_hex(row.plain)); return {};
    case SessionChannel::Verdict::kReplayed: return "replayed";
    case SessionChannel::Verdict::kWrongMac: return "wrong mac";
    case SessionChannel::Verdict::kForbidden: return "forbidden";
    default: ADD_FAILURE() << place(session, row); return "other";
  }
}

TEST(AnnotatedSessions, ReplaysAndPlainFramesOfClientsAreDroppedForTheReasonThatIsWritten) {
  const auto sessions = annotated_sessions();
  if (sessions.empty()) GTEST_SKIP() << kMissing;
  const std::map<std::string, std::string> expected{{"the very same wrapper again: nothing may happen", "replayed"},
                                                    {"MAC changed", "wrong mac"},
                                                    {"sequence 999: behind", "replayed"},
                                                    {"wrapper inside a wrapper", "forbidden"},
                                                    {"plain", "plain"}};
  std::set<std::string> found;
  for (const auto& session : sessions) {
    if (!session.has("session key")) continue;
    Ccm ccm;
    SessionChannel server(session.id(), key_of(session.keys.at("session key")), {9, 9, 9, 9, 9, 9});
    for (const auto& row : session.rows) {
      const bool handshake = !is_wrapper(row.frame) && row.note.empty();
      if (row.direction != 'C' || handshake) continue;
      const auto reason = strict_reason(session, server, ccm, row);
      const auto wanted = expected.find(row.note);
      EXPECT_EQ(reason.value_or("taken"), wanted == expected.end() ? "taken" : wanted->second) << place(session, row);
      if (reason) found.insert(row.note);
    }
  }
  EXPECT_EQ(found.size(), expected.size());
}

/// Our client with the recorded private key and serial number, and the recorded server.
class RecordedServer : public SessionFixture {
 protected:
  void play(const AnnotatedSession& recorded) {
    begin(recorded);
    for (const auto& row : recorded.rows) {
      const auto at = start_time + std::chrono::duration_cast<Duration>(std::chrono::duration<double>(row.seconds));
      time.run_for(std::max(Duration{}, at - time.now()));
      row.direction == 'C' ? send(recorded, row) : receive(recorded, row);
    }
    expect_received(recorded);
  }

  void begin(const AnnotatedSession& recorded) {
    session.reset();
    sent.clear(), received.clear(), ends.clear(), notes.clear();
    counters = {};
    compared = 0, ups = 0, follows = true;
    start_time = time.now();
    Bytes serial(6);
    for (const auto& row : recorded.rows) {
      if (row.direction != 'C' || !is_wrapper(row.frame)) continue;
      const auto wrapper = wrapper_of(row.frame);
      serial.assign(wrapper.head.serial.begin(), wrapper.head.serial.end());
    }
    give_random(Secret(hex(recorded.keys.at("client private key"))), serial);
    keys.user = recorded.user().value_or(2);
    keys.device_code.reset();
    if (recorded.has("device authentication code"))
      keys.device_code = PasswordKey{key_of(recorded.keys.at("device authentication code")), {}};
    keys.user_key.key = Key();
    for (const auto& [name, value] : recorded.keys) {
      if (name.starts_with("user ")) keys.user_key.key = key_of(value);
    }
    if (recorded.file.starts_with("xknx")) keys.user_key.key = xknx_user_key();
    start();
  }

  /// The clients of xknx have the passwords of the same keyring.
  Key xknx_user_key() const {
    return key_of(keys.user == 2 ? "feffdd26a166bd804f1331bd86513d1a" : "3209c23dc504344375fda44f9ede708c");
  }

  void send(const AnnotatedSession& recorded, const AnnotatedRow& row) {
    const auto frame = wire::read_frame(row.plain.empty() ? row.frame : row.plain).value();
    const bool ours =
        frame.service == ServiceCode::kSessionRequest || frame.service == ServiceCode::kSessionAuthenticate;
    if (!is_wrapper(row.frame) && !ours) return;  // what our client never sends: plain frames
    // A client that breaks the rules on purpose: from here on only what the server sends is looked at.
    follows = follows && (ours || (session->up() && wrapper_of(row.frame).head.sequence == next_sequence()));
    if (!follows) return;
    if (!ours) close_or_send(frame, row.plain);
    ASSERT_LT(compared, sent.size()) << place(recorded, row);
    EXPECT_EQ(base::to_hex(sent[compared++]), base::to_hex(row.frame)) << place(recorded, row);
  }
  std::uint64_t next_sequence() const { return compared - 1; }  // the request has none

  void close_or_send(const wire::Frame& frame, const Bytes& plain) {
    const bool closes = frame.service == ServiceCode::kSessionStatus && Status(frame.body[0]) == Status::kClose;
    closes ? session->close() : session->send(plain);
  }

  void receive(const AnnotatedSession& recorded, const AnnotatedRow& row) {
    if (!is_wrapper(row.frame) || wrapper_of(row.frame).head.session == recorded.id()) session->receive(row.frame);
  }

  /// All frames of the server that a client may take, in order.
  void expect_received(const AnnotatedSession& recorded) {
    if (ends.size() + std::size_t(session->up()) == 0) return;
    std::vector<std::string> expected, got;
    std::optional<std::uint64_t> last;
    for (const auto& row : recorded.rows) {
      if (row.direction != 'S' || !is_wrapper(row.frame)) continue;
      const auto sequence = wrapper_of(row.frame).head.sequence;
      if (last && sequence <= *last) continue;
      last = sequence;
      if (wire::read_frame(row.plain)->service != ServiceCode::kSessionStatus)
        expected.push_back(base::to_hex(row.plain));
    }
    for (const auto& frame : received) got.push_back(base::to_hex(frame));
    EXPECT_EQ(got, expected) << recorded.file;
  }

  SteadyTime start_time{};
  std::size_t compared = 0;
  bool follows = true;
};

TEST_F(RecordedServer, OurClientSendsTheRecordedBytesAndTakesTheRecordedAnswers) {
  const auto sessions = annotated_sessions();
  if (sessions.empty()) GTEST_SKIP() << kMissing;
  std::size_t frames = 0;
  for (const auto& recorded : sessions) {
    if (!recorded.has("client private key")) continue;
    play(recorded);
    frames += compared;
  }
  EXPECT_GT(frames, 90U);
}

struct Expected {
  Session::Cause cause;
  std::uint8_t status;
};

TEST_F(RecordedServer, EachRefusalEndsTheSessionForTheReasonThatIsWritten) {
  const std::map<std::string, Expected> expected{
      {"refused-wrong-password", {Session::Cause::kNotAuthenticated, 1}},
      {"refused-unknown-user", {Session::Cause::kNotAuthenticated, 2}},
      {"refused-connect-before-authentication", {Session::Cause::kNotAuthenticated, 2}},
      {"wrong-device-password", {Session::Cause::kWrongServer, 0}},
      {"closed-when-silent", {Session::Cause::kClosed, 3}},
  };
  const auto sessions = annotated_sessions();
  if (sessions.empty()) GTEST_SKIP() << kMissing;
  for (const auto& recorded : sessions) {
    const auto wanted = expected.find(recorded.file);
    if (!recorded.has("client private key")) continue;
    play(recorded);
    ASSERT_EQ(ends.size(), wanted == expected.end() ? 0U : 1U) << recorded.file << (ends.empty() ? "" : ends[0].why);
    if (ends.empty()) continue;
    EXPECT_EQ(ends[0].cause, wanted->second.cause) << recorded.file << ends[0].why;
    EXPECT_EQ(ends[0].status, wanted->second.status) << recorded.file;
    const bool answers = ends[0].cause == Session::Cause::kWrongServer;
    EXPECT_EQ(sent.size() == 1U, answers) << "a server that cannot prove its identity gets nothing";
  }
}

TEST_F(RecordedServer, OldSequenceNumbersAndPlainAnswersAreCounted) {
  const auto sessions = annotated_sessions();
  if (sessions.empty()) GTEST_SKIP() << kMissing;
  for (const auto& recorded : sessions) {
    if (recorded.file != "refused-replay" && recorded.file != "plain-frame-on-secured-channel") continue;
    play(recorded);
    EXPECT_EQ(counters.replays, recorded.file == "refused-replay" ? 1U : 0U);
    EXPECT_EQ(counters.plain_frames, recorded.file == "refused-replay" ? 0U : 1U);
  }
}

}  // namespace
}  // namespace rubicon::networks::knx::secure
