#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/write.hpp>
#include <memory>
#include <vector>

#include "transport/worlds.h"

namespace rubicon::transport {
namespace {

using boost::asio::ip::tcp;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

/// A listening server that takes one connection at a time and says nothing by itself.
struct Server {
  virtual ~Server() = default;
  virtual Endpoint at() const = 0;
  virtual void send(std::string text) = 0;
  virtual void hang_up() = 0;
  virtual void read(bool on) = 0;

  std::string heard;
  int accepted = 0;
  bool ended = false;  ///< the connection
};

struct MachineServer final : Server {
  explicit MachineServer(Loop& l)
      : loop(l), acceptor(l.context(), {boost::asio::ip::address_v4::loopback(), 0}), socket(l.context()) {
    acceptor.async_accept(socket, [this](auto error) {
      if (error) return;
      ++accepted;
      receive();
    });
  }
  Endpoint at() const override { return {"127.0.0.1", acceptor.local_endpoint().port()}; }
  void send(std::string text) override { boost::asio::write(socket, boost::asio::buffer(text)); }
  void hang_up() override { socket.close(); }
  void read(bool on) override {
    if (!std::exchange(reading, on) && on) receive();
  }
  void receive() {
    if (!reading || !socket.is_open()) return;
    socket.async_read_some(boost::asio::buffer(buffer), [this](auto error, std::size_t size) {
      ended = ended || error;
      if (error) return;
      heard.append(buffer.data(), size);
      receive();
    });
  }

  Loop& loop;
  tcp::acceptor acceptor;
  tcp::socket socket;
  std::array<char, 65536> buffer{};
  bool reading = true;
};

struct MemoryServer final : Server {
  explicit MemoryServer(MemoryNet& n) : net(n) {
    listener = net.tcp.listen({"127.0.0.1", 3671}, [this](auto accepting) {
      stream = std::move(accepting);
      ++accepted;
      return TcpCallbacks{
          {}, [this](ByteView bytes) { heard += base::as_text(bytes); }, [this](const Error&) { ended = true; }};
    });
  }
  Endpoint at() const override { return {"127.0.0.1", 3671}; }
  void send(std::string text) override { ASSERT_TRUE(stream->send(base::as_bytes(text))); }
  void hang_up() override { stream.reset(); }
  void read(bool on) override { net.tcp.stall(!on); }

  MemoryNet& net;
  std::unique_ptr<MemoryListener> listener;
  std::unique_ptr<TcpStream> stream;
};

/// A client and all that it received.
struct Client {
  std::string heard;
  int connected = 0;
  std::vector<Error> failures;
  std::unique_ptr<TcpStream> stream;

  Result<void> open(Transports& transports, const Endpoint& to, Duration patience = 5s) {
    TcpCallbacks calls;
    calls.connected = [this] { ++connected; };
    calls.received = [this](ByteView bytes) { heard += base::as_text(bytes); };
    calls.failed = [this](Error error) { failures.push_back(std::move(error)); };
    auto opened = transports.open_tcp({to, patience}, std::move(calls));
    if (!opened) return fail(opened.error());
    stream = std::move(*opened);
    return {};
  }
};

class Tcp : public ::testing::TestWithParam<bool> {
 protected:
  Tcp() {
    if (GetParam()) {
      auto machine = std::make_unique<MachineWorld>();
      server = std::make_unique<MachineServer>(machine->loop);
      world = std::move(machine);
    } else {
      auto memory = std::make_unique<MemoryWorld>();
      server = std::make_unique<MemoryServer>(memory->net);
      world = std::move(memory);
    }
  }
  ~Tcp() override { server.reset(); }
  Transports& transports() { return world->transports(); }
  void connect() {
    ASSERT_TRUE(client.open(transports(), server->at()));
    EXPECT_EQ(client.connected, 0) << "never from inside the call";
    ASSERT_TRUE(world->until([&] { return client.connected == 1 && server->accepted == 1; }));
  }

  std::unique_ptr<World> world;
  std::unique_ptr<Server> server;
  Client client;
};

TEST_P(Tcp, BytesGoBothWaysInOrder) {
  connect();
  EXPECT_TRUE(client.stream->connected());
  EXPECT_NE(client.stream->local().port, 0);
  EXPECT_EQ(client.stream->local().address, "127.0.0.1");
  for (const auto* text : {"one ", "", "two ", "three"}) ASSERT_TRUE(client.stream->send(base::as_bytes(text)));
  server->send("back");
  ASSERT_TRUE(world->until([&] { return server->heard.size() == 13 && client.heard.size() == 4; }));
  EXPECT_EQ(server->heard, "one two three");
  EXPECT_EQ(client.heard, "back");
}

TEST_P(Tcp, WhatIsSentBeforeTheConnectionIsThereWaitsForIt) {
  ASSERT_TRUE(client.open(transports(), server->at()));
  ASSERT_TRUE(client.stream->send(base::as_bytes("early")));
  EXPECT_FALSE(client.stream->connected());
  EXPECT_EQ(client.stream->local(), Endpoint());
  EXPECT_TRUE(world->until([&] { return server->heard == "early"; }));
}

TEST_P(Tcp, AStreamWithoutAReaderRefusesMoreAndLosesNothing) {
  connect();
  server->read(false);
  const std::string block(16 * 1024, 'x');
  std::size_t taken = 0;
  Result<void> sent;
  for (int i = 0; i < 5000 && (sent = client.stream->send(base::as_bytes(block))); ++i) taken += block.size();
  ASSERT_FALSE(sent);
  EXPECT_EQ(sent.error().code, ErrorCode::kBusy);
  EXPECT_THAT(sent.error().text, HasSubstr(to_string(server->at())));
  server->read(true);
  ASSERT_TRUE(world->until([&] { return server->heard.size() >= taken; }));
  EXPECT_EQ(server->heard.size(), taken);
  EXPECT_TRUE(client.stream->send(base::as_bytes(block)));
}

TEST_P(Tcp, WhatTheOtherEndHasNotAcknowledgedIsCounted) {
  ASSERT_TRUE(client.open(transports(), server->at()));
  ASSERT_TRUE(client.stream->send(base::as_bytes("early")));
  EXPECT_EQ(client.stream->unacknowledged(), 5u) << "waits for the connection";
  ASSERT_TRUE(world->until([&] { return server->heard == "early" && client.stream->unacknowledged() == 0; }));

  server->read(false);
  const std::string block(16 * 1024, 'x');
  std::size_t taken = 0;
  for (int i = 0; i < 5000 && client.stream->send(base::as_bytes(block)); ++i) taken += block.size();
  EXPECT_GT(client.stream->unacknowledged(), 0u);
  EXPECT_GE(client.stream->unacknowledged(), client.stream->queued());
  EXPECT_LE(client.stream->unacknowledged(), taken);
  server->read(true);
  EXPECT_TRUE(world->until([&] { return client.stream->unacknowledged() == 0; }));
  EXPECT_TRUE(world->until([&] { return server->heard.size() == 5 + taken; }));

  server->hang_up();
  ASSERT_TRUE(world->until([&] { return !client.failures.empty(); }));
  EXPECT_EQ(client.stream->unacknowledged(), 0u);
}

TEST_P(Tcp, TheOtherEndsCloseIsReportedOnceAndNothingIsSentAfterIt) {
  connect();
  server->send("bye");
  server->hang_up();
  ASSERT_TRUE(world->until([&] { return !client.failures.empty(); }));
  EXPECT_EQ(client.heard, "bye") << "what came before is heard";
  EXPECT_THAT(client.failures, SizeIs(1));
  EXPECT_EQ(client.failures[0].code, ErrorCode::kUnreachable);
  EXPECT_THAT(client.failures[0].text, HasSubstr(to_string(server->at())));
  EXPECT_FALSE(client.stream->connected());
  EXPECT_EQ(client.stream->send(base::as_bytes("x")).error().code, ErrorCode::kUnreachable);
}

TEST_P(Tcp, AConnectionToAPortWithoutAListenerIsRefused) {
  const auto gone = server->at();
  server.reset();
  ASSERT_TRUE(client.open(transports(), gone));
  EXPECT_THAT(client.failures, IsEmpty()) << "never from inside the call";
  ASSERT_TRUE(world->until([&] { return !client.failures.empty(); }));
  EXPECT_EQ(client.failures[0].code, ErrorCode::kUnreachable);
  EXPECT_THAT(client.failures[0].text, HasSubstr("cannot connect: Connection refused"));
  EXPECT_EQ(client.connected, 0);
}

TEST_P(Tcp, WhatWasSentBeforeTheStreamWasDestroyedArrives) {
  connect();
  ASSERT_TRUE(client.stream->send(base::as_bytes("last words")));
  client.stream.reset();
  EXPECT_TRUE(world->until([&] { return server->heard == "last words"; }));
  EXPECT_THAT(client.failures, IsEmpty());
}

TEST_P(Tcp, WhatAnAbortedStreamStillHadToSendIsThrownAway) {
  connect();
  const std::string block(16 * 1024, 'x');
  std::size_t taken = 0;
  const int most = GetParam() ? 5000 : 3;  // more than fits, or what still waits for the end of this turn
  for (int i = 0; i < most && client.stream->send(base::as_bytes(block)); ++i) taken += block.size();
  client.stream->abort();
  EXPECT_FALSE(client.stream->connected());
  EXPECT_EQ(client.stream->send(base::as_bytes("x")).error().code, ErrorCode::kUnreachable);
  client.stream.reset();
  ASSERT_TRUE(world->until([&] { return server->ended; }));
  // On the machine the queue of the stream goes in any case; here it is all.
  EXPECT_LT(server->heard.size() + (GetParam() ? TcpStream::kMaxQueued : 0), taken);
  EXPECT_THAT(client.failures, IsEmpty());
}

TEST_P(Tcp, TheStreamMayBeDestroyedWhileItIsCalled) {
  for (const bool when_connected : {true, false}) {
    std::unique_ptr<TcpStream> mortal;
    int called = 0;
    TcpCallbacks calls;
    calls.connected = [&] {
      if (when_connected) ++called, mortal.reset();
    };
    calls.received = [&](ByteView) { ADD_FAILURE(); };
    calls.failed = [&](const Error&) { ++called, mortal.reset(); };
    if (!when_connected) server.reset();
    mortal =
        std::move(transports().open_tcp({server ? server->at() : Endpoint{"127.0.0.1", 1}}, std::move(calls))).value();
    EXPECT_TRUE(world->until([&] { return called == 1; }));
    EXPECT_EQ(mortal, nullptr);
  }
}

TEST_P(Tcp, RefusesWhatIsNoEndpoint) {
  EXPECT_EQ(client.open(transports(), {"localhost", 3671}).error().code, ErrorCode::kInvalid);
  EXPECT_EQ(client.open(transports(), {"127.0.0.1", 0}).error().code, ErrorCode::kInvalid);
}

INSTANTIATE_TEST_SUITE_P(On, Tcp, ::testing::Bool(),
                         [](const auto& machine) { return std::string(machine.param ? "TheMachine" : "Memory"); });

TEST(MachineTcp, AFullBacklogAnswersNoClientAndTheAttemptEnds) {
  MachineWorld world;
  // Linux takes one connection more than the backlog, and lets those after it wait.
  tcp::acceptor full(world.loop.context(), tcp::v4());
  full.bind({boost::asio::ip::address_v4::loopback(), 0});
  full.listen(0);
  const Endpoint at{"127.0.0.1", full.local_endpoint().port()};
  Client first, second;
  ASSERT_TRUE(first.open(world.local, at));
  ASSERT_TRUE(world.until([&] { return first.connected == 1; }));
  ASSERT_TRUE(second.open(world.local, at, 50ms));
  ASSERT_TRUE(world.until([&] { return !second.failures.empty(); }));
  EXPECT_EQ(second.failures[0].code, ErrorCode::kUnreachable);
  EXPECT_THAT(second.failures[0].text, HasSubstr("no answer within 0.05 s"));
}

/// The descriptor of this process whose socket is bound here; -1 = none.
int descriptor_of(const Endpoint& local) {
  for (int descriptor = 3; descriptor < 1024; ++descriptor) {
    sockaddr_in address{};
    socklen_t size = sizeof address;
    if (::getsockname(descriptor, reinterpret_cast<sockaddr*>(&address), &size) == 0 && address.sin_family == AF_INET &&
        ntohs(address.sin_port) == local.port)
      return descriptor;
  }
  return -1;
}

int tcp_option_of(int descriptor, int level, int option) {
  int value = -1;
  socklen_t size = sizeof value;
  ::getsockopt(descriptor, level, option, &value, &size);
  return value;
}

TEST(MachineTcp, ADeadPeerIsNoticedWhetherWeSendOrNot) {
  MachineWorld world;
  MachineServer server(world.loop);
  Client client;
  ASSERT_TRUE(client.open(world.local, server.at()));
  ASSERT_TRUE(world.until([&] { return client.connected == 1; }));
  const int descriptor = descriptor_of(client.stream->local());
  EXPECT_NE(tcp_option_of(descriptor, IPPROTO_TCP, TCP_NODELAY), 0);
  EXPECT_EQ(tcp_option_of(descriptor, IPPROTO_TCP, TCP_USER_TIMEOUT), 30000);
  EXPECT_NE(tcp_option_of(descriptor, SOL_SOCKET, SO_KEEPALIVE), 0);
  EXPECT_EQ(tcp_option_of(descriptor, IPPROTO_TCP, TCP_KEEPIDLE), 10);
  EXPECT_EQ(tcp_option_of(descriptor, IPPROTO_TCP, TCP_KEEPINTVL), 10);
  EXPECT_EQ(tcp_option_of(descriptor, IPPROTO_TCP, TCP_KEEPCNT), 3);
}

TEST(MachineTcp, ReadsInLargerPiecesWhileTheOtherEndIsFastAndInSmallOnesAfterwards) {
  MachineWorld world;
  MachineServer server(world.loop);
  std::vector<std::size_t> pieces;
  std::size_t got = 0, sent = 0;
  TcpCallbacks calls;
  calls.received = [&](ByteView bytes) {
    pieces.push_back(bytes.size());
    got += bytes.size();
  };
  const auto stream = world.local.open_tcp({server.at()}, std::move(calls)).value();
  ASSERT_TRUE(world.until([&] { return server.accepted == 1; }));
  const auto send = [&](std::size_t size) {
    pieces.clear();
    server.send(std::string(size, 'x'));
    sent += size;
    return world.until([&] { return got == sent; });
  };
  ASSERT_TRUE(send(60'000));
  EXPECT_EQ(pieces.front(), 8192U);
  EXPECT_GT(*std::max_element(pieces.begin(), pieces.end()), 8192U);
  for (int quiet = 0; quiet < 4; ++quiet) ASSERT_TRUE(send(10));
  ASSERT_TRUE(send(60'000));
  EXPECT_EQ(pieces.front(), 8192U) << "the buffer of the burst is still there";
}

TEST(MachineTcp, WithoutALoopThereAreNoConnections) {
  EXPECT_EQ(LocalTransports().open_tcp({}, {}).error().code, ErrorCode::kUnsupported);
  EXPECT_EQ(MemoryTransports().open_tcp({}, {}).error().code, ErrorCode::kUnsupported);
}

TEST(MemoryTcp, StreamsArriveInPiecesOfTheSizeATestWants) {
  MemoryWorld world;
  std::vector<std::string> pieces;
  std::unique_ptr<TcpStream> kept;
  const auto listener = world.net.tcp.listen({"10.0.0.1", 3671}, [&](auto stream) {
    kept = std::move(stream);
    return TcpCallbacks{{}, [&](ByteView bytes) { pieces.emplace_back(base::as_text(bytes)); }, {}};
  });
  Client client;
  ASSERT_TRUE(client.open(world.memory, {"10.0.0.1", 3671}));
  world.time.run_for(1s);
  const auto send = [&] {
    for (const auto* text : {"abc", "de"}) ASSERT_TRUE(client.stream->send(base::as_bytes(text)));
    world.time.run_for(1s);
  };
  send();
  EXPECT_THAT(pieces, testing::ElementsAre("abcde"));
  pieces.clear();
  world.net.tcp.segment = 2;
  send();
  EXPECT_THAT(pieces, testing::ElementsAre("ab", "cd", "e"));
  pieces.clear();
  world.net.tcp.segment = 1;
  send();
  EXPECT_THAT(pieces, SizeIs(5));
}

TEST(MemoryTcp, NoAnswerAndABrokenConnectionWhenATestWantsThem) {
  MemoryWorld world;
  MemoryServer server(world.net);
  Client one, other;
  ASSERT_TRUE(one.open(world.memory, server.at()));
  world.time.run_for(1s);
  EXPECT_EQ(world.net.tcp.open_streams(), 2u);
  world.net.tcp.answers = false;
  ASSERT_TRUE(other.open(world.memory, server.at(), 3s));
  world.time.run_for(2999ms);
  EXPECT_THAT(other.failures, IsEmpty());
  world.time.run_for(1ms);
  ASSERT_THAT(other.failures, SizeIs(1));
  EXPECT_THAT(other.failures[0].text, HasSubstr("no answer within 3 s"));
  EXPECT_THAT(one.failures, IsEmpty());
  world.net.tcp.cut();
  world.time.run_for(0s);
  ASSERT_THAT(one.failures, SizeIs(1));
  EXPECT_EQ(one.failures[0].code, ErrorCode::kIo);
  EXPECT_EQ(world.net.tcp.open_streams(), 0u);
}

}  // namespace
}  // namespace rubicon::transport
