#include <gtest/gtest.h>

#include "base/virtual_scheduler.h"
#include "networks/knx/line/tunnel_sockets.h"
#include "networks/knx/secure/session.h"
#include "networks/knx/wire/message.h"
#include "support/knx_server.h"
#include "support/memory/memory_udp.h"

namespace rubicon::knx_simulator {
namespace {

using namespace std::chrono_literals;
using namespace networks::knx;

secure::Key one_key(std::uint8_t value) {
  secure::Key key;
  key.span()[0] = value;
  return key;
}

/// A client with a session of its own over TCP, which sends what it likes.
class RawClient {
 public:
  RawClient(VirtualScheduler& time, transport::MemoryNet& net, const std::string& host = "10.0.0.7",
            const std::string& server = "10.0.0.9")
      : session_(time, keys_, secure::Session::Settings{}, counters_, callbacks()) {
    host_.join(net, host);
    transport::TcpOptions options;
    options.remote = {server, 3671};
    transport::TcpCallbacks calls;
    calls.connected = [this] { session_.start(); };
    calls.received = [this](ByteView bytes) { take(bytes); };
    calls.failed = [](const Error&) {};
    stream_ = std::move(host_.open_tcp(options, std::move(calls)).value());
    time.run_for(10ms);
  }
  secure::Session& session() { return session_; }
  /// The tunnel of the last CONNECT_RESPONSE; nullopt: refused, or none came.
  std::optional<wire::IndividualAddress> connected_to() const {
    if (received.empty()) return std::nullopt;
    const auto message = wire::read_message(received.back());
    const auto* response = message ? std::get_if<wire::ConnectResponse>(&*message) : nullptr;
    return response != nullptr && response->status == 0 ? std::optional(response->crd.address) : std::nullopt;
  }
  void send_plain(const Bytes& frame) { EXPECT_TRUE(stream_->send(frame)); }

  std::vector<wire::ServiceCode> heard_plain;
  std::vector<Bytes> received;

 private:
  secure::Session::Callbacks callbacks() {
    secure::Session::Callbacks calls;
    calls.transmit = [this](ByteView frame) { EXPECT_TRUE(stream_->send(frame)); };
    calls.up = [] {};
    calls.received = [this](ByteView frame) { received.emplace_back(frame.begin(), frame.end()); };
    calls.ended = [](const secure::Session::End&) {};
    return calls;
  }
  void take(ByteView bytes) {
    frames_.append(bytes);
    for (auto frame = frames_.next(); frame && !frame->empty(); frame = frames_.next()) {
      const auto service = wire::read_frame(*frame)->service;
      if (service != wire::ServiceCode::kSecureWrapper) heard_plain.push_back(service);
      session_.receive(*frame);
    }
  }

  secure::SessionKeys keys_{2, {one_key(2), {}}, secure::PasswordKey{one_key(1), {}}};
  secure::SessionCounters counters_;
  transport::MemoryTransports host_;
  line::FrameStream frames_;
  std::unique_ptr<transport::TcpStream> stream_;
  secure::Session session_;
};

class SecureServer : public testing::Test {
 protected:
  SecureServer() {
    support::KnxServer::Options with;
    with.secure = SecureOptions{one_key(1), {{2, one_key(2), 0}}};
    server = std::make_unique<support::KnxServer>(time, net, with);
  }
  std::uint8_t open_tunnel(RawClient& client) {
    client.session().send(write(wire::ConnectRequest{}));
    time.run_for(10ms);
    return server->channels().empty() ? std::uint8_t{0} : server->channels().back();
  }

  VirtualScheduler time;
  transport::MemoryNet net{time};
  std::unique_ptr<support::KnxServer> server;
};

TEST_F(SecureServer, ATunnelBelongsToTheSessionThatOpenedIt) {
  RawClient owner(time, net), other(time, net, "10.0.0.8");
  ASSERT_TRUE(owner.session().up() && other.session().up());
  const auto channel = open_tunnel(owner);
  const Bytes cemi = *base::from_hex("1100bce000000a070300800c33");
  const auto request = write(wire::ConnectionRequest{wire::ServiceCode::kTunnellingRequest, {channel, 0, 0}, cemi});
  other.session().send(request);
  other.session().send(write(wire::DisconnectRequest{channel, {}}));
  time.run_for(10ms);
  EXPECT_TRUE(server->heard().empty());
  EXPECT_EQ(server->channels().size(), 1U);
  owner.session().send(request);
  time.run_for(10ms);
  EXPECT_EQ(server->heard().size(), 1U);
  owner.session().close();
  time.run_for(10ms);
  EXPECT_TRUE(server->channels().empty()) << "the tunnel ends with its session";
}

TEST_F(SecureServer, TheTunnelOfAUserIsKeptForThatUser) {
  support::KnxServer::Options with;
  with.at.address = "10.0.0.10";
  with.tunnels = 2;
  with.secure = SecureOptions{one_key(1), {{3, one_key(3), 0x11c8}, {2, one_key(2), 0}}};
  const support::KnxServer reserving(time, net, with);
  RawClient client(time, net, "10.0.0.7", "10.0.0.10"), other(time, net, "10.0.0.8", "10.0.0.10");
  client.session().send(write(wire::ConnectRequest{}));
  time.run_for(10ms);
  other.session().send(write(wire::ConnectRequest{}));
  time.run_for(10ms);
  EXPECT_EQ(client.connected_to(), wire::IndividualAddress{0x11c9}) << "user 2 gets any but the tunnel of user 3";
  EXPECT_EQ(other.connected_to(), std::nullopt);
}

TEST_F(SecureServer, ATunnelOfAUserMustBeOneOfTheServer) {
  ServerOptions options;
  options.secure = SecureOptions{one_key(1), {{2, one_key(2), 0}, {3, one_key(3), 0x11cb}}};
  EXPECT_TRUE(check_users(options));
  options.tunnels = 3;
  const auto checked = check_users(options);
  ASSERT_FALSE(checked);
  EXPECT_EQ(checked.error().text, "user 3 has the tunnel 1.1.203, expected one from 1.1.200 to 1.1.202");
}

TEST_F(SecureServer, PlainFramesAreRefusedOrDropped) {
  RawClient client(time, net);
  const auto channel = open_tunnel(client);
  const Bytes cemi = *base::from_hex("1100bce000000a070300800c33");
  client.send_plain(write(wire::ConnectionRequest{wire::ServiceCode::kTunnellingRequest, {channel, 0, 0}, cemi}));
  client.send_plain(write(wire::DisconnectRequest{channel, {}}));
  client.send_plain(write(wire::ConnectRequest{}));
  client.send_plain(write(wire::DescriptionRequest{}));
  time.run_for(10ms);
  EXPECT_TRUE(server->heard().empty());
  EXPECT_EQ(server->channels().size(), 1U);
  EXPECT_EQ(server->counters.plain_frames, 3U);
  const std::vector<wire::ServiceCode> expected{wire::ServiceCode::kSessionResponse,
                                                wire::ServiceCode::kConnectResponse,
                                                wire::ServiceCode::kDescriptionResponse};
  EXPECT_EQ(client.heard_plain, expected);
}

TEST_F(SecureServer, AnswersExtendedSearchesThatItMatches) {
  RawClient client(time, net);
  const auto search = [&](std::vector<wire::Srp> parameters, bool extended = true) {
    client.heard_plain.clear();
    client.send_plain(write(wire::SearchRequest{{}, extended, std::move(parameters)}));
    time.run_for(10ms);
    return client.heard_plain;
  };
  using Type = wire::Srp::Type;
  const std::vector answer{wire::ServiceCode::kSearchResponseExtended};
  EXPECT_EQ(search({}), answer);
  EXPECT_EQ(search({{Type::kWantedDibs, true, {6, 7}}, {Type::kFamily, true, {9, 1}}}), answer);
  EXPECT_EQ(search({{Type::kMac, false, Bytes(6, 1)}}), answer) << "not mandatory";
  EXPECT_TRUE(search({{Type::kMac, true, Bytes(6, 1)}}).empty());
  EXPECT_TRUE(search({{Type::kFamily, true, {4, 3}}}).empty());
  EXPECT_TRUE(search({{Type::kProgrammingMode, true, {}}}).empty());
  EXPECT_TRUE(search({}, false).empty()) << "as knxd, it answers searches on the multicast group only";
  EXPECT_EQ(server->counters.plain_frames, 0U);
}

}  // namespace
}  // namespace rubicon::knx_simulator
