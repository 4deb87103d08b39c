#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/resource.h>
#include <sys/socket.h>

#include <ctime>
#include <memory>
#include <vector>

#include "transport/worlds.h"

namespace rubicon::transport {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

/// One end of a connection and all that it received.
struct End {
  std::string heard;
  int connected = 0;
  std::vector<Error> failures;
  std::unique_ptr<TcpStream> stream;

  TcpCallbacks calls() {
    return {[this] { ++connected; }, [this](ByteView bytes) { heard += base::as_text(bytes); },
            [this](Error error) { failures.push_back(std::move(error)); }};
  }
  void connect(Transports& transports, const Endpoint& to) {
    auto opened = transports.open_tcp({to}, calls());
    ASSERT_TRUE(opened);
    stream = std::move(*opened);
  }
  void send(std::string_view text) { EXPECT_TRUE(stream->send(base::as_bytes(text))); }
};

struct Listening {
  std::vector<std::unique_ptr<End>> accepted;
  std::vector<Error> failures;
  std::unique_ptr<TcpListener> listener;

  Result<void> open(Transports& transports, const Endpoint& at) {
    auto opened = transports.listen_tcp(
        at,
        [this](std::unique_ptr<TcpStream> stream) {
          accepted.push_back(std::make_unique<End>());
          accepted.back()->stream = std::move(stream);
          return accepted.back()->calls();
        },
        [this](Error error) { failures.push_back(std::move(error)); });
    if (!opened) return fail(opened.error());
    listener = std::move(*opened);
    return {};
  }
};

class Listen : public ::testing::TestWithParam<Where> {
 protected:
  Transports& transports() { return world->transports(); }
  void connect() {
    ASSERT_TRUE(server.open(transports(), {"127.0.0.1", 0}));
    client.connect(transports(), server.listener->local());
    ASSERT_TRUE(world->until([&] { return client.connected == 1 && server.accepted.size() == 1; }));
  }
  End& ours() { return *server.accepted.front(); }

  std::unique_ptr<World> world = make_world(GetParam());
  Listening server;
  End client;
};

TEST_P(Listen, APortThatTheSystemChoseTakesConnectionsThatWorkBothWays) {
  connect();
  EXPECT_EQ(server.listener->local().address, "127.0.0.1");
  EXPECT_NE(server.listener->local().port, 0);
  EXPECT_TRUE(ours().stream->connected());
  EXPECT_EQ(ours().stream->remote(), client.stream->local());
  EXPECT_EQ(ours().stream->local(), client.stream->remote());
  ours().send("hello");
  client.send("back");
  ASSERT_TRUE(world->until([&] { return client.heard == "hello" && ours().heard == "back"; }));
  EXPECT_EQ(ours().connected, 0) << "the other end made the connection";
}

TEST_P(Listen, WhatIsSentInsideTheAcceptArrives) {
  std::vector<std::unique_ptr<TcpStream>> kept;
  auto listener = std::move(transports().listen_tcp({"127.0.0.1", 0}, [&](std::unique_ptr<TcpStream> stream) {
                    EXPECT_TRUE(stream->send(base::as_bytes("greetings")));
                    kept.push_back(std::move(stream));
                    return TcpCallbacks{};
                  })).value();
  client.connect(transports(), listener->local());
  EXPECT_TRUE(world->until([&] { return client.heard == "greetings"; }));
}

TEST_P(Listen, AConnectionThatIsNotKeptIsHungUpOn) {
  auto listener = std::move(transports().listen_tcp({"127.0.0.1", 0}, [&](const std::unique_ptr<TcpStream>&) {
                    return TcpCallbacks{};
                  })).value();
  client.connect(transports(), listener->local());
  EXPECT_TRUE(world->until([&] { return !client.failures.empty(); }));
}

TEST_P(Listen, SeveralAreConnectedAtOnceAndEachHearsItsOwn) {
  connect();
  End second;
  second.connect(transports(), server.listener->local());
  ASSERT_TRUE(world->until([&] { return second.connected == 1 && server.accepted.size() == 2; }));
  server.accepted[0]->send("one");
  server.accepted[1]->send("two");
  ASSERT_TRUE(world->until([&] { return client.heard.size() == 3 && second.heard.size() == 3; }));
  EXPECT_EQ(client.heard, "one");
  EXPECT_EQ(second.heard, "two");
}

TEST_P(Listen, ConnectionsLiveOnWithoutThePortAndThePortIsFreeAtOnce) {
  connect();
  const auto at = server.listener->local();
  server.listener.reset();
  client.send("still there");
  ASSERT_TRUE(world->until([&] { return ours().heard == "still there"; }));
  End late;
  late.connect(transports(), at);
  ASSERT_TRUE(world->until([&] { return !late.failures.empty(); }));
  Listening again;
  EXPECT_TRUE(again.open(transports(), at)) << "though a connection of the port lives";
}

TEST_P(Listen, ATakenPortIsBusy) {
  connect();
  Listening second;
  const auto refused = second.open(transports(), server.listener->local());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kBusy);
  EXPECT_THAT(refused.error().text, HasSubstr(to_string(server.listener->local())));
}

TEST_P(Listen, WhatIsNoAddressIsInvalid) {
  for (const auto* address : {"localhost", ""}) {
    const auto refused = server.open(transports(), {address, 0});
    ASSERT_FALSE(refused) << address;
    EXPECT_EQ(refused.error().code, ErrorCode::kInvalid);
  }
}

TEST_P(Listen, BothEndsHearOfTheOthersClose) {
  connect();
  client.stream.reset();
  ASSERT_TRUE(world->until([&] { return !ours().failures.empty(); }));
  EXPECT_THAT(ours().failures[0].text, HasSubstr("the other end closed"));
  End second;
  second.connect(transports(), server.listener->local());
  ASSERT_TRUE(world->until([&] { return second.connected == 1 && server.accepted.size() == 2; }));
  server.accepted[1]->stream.reset();
  EXPECT_TRUE(world->until([&] { return !second.failures.empty(); }));
}

TEST_P(Listen, AHeldStreamPushesBackOnItsSenderAndLosesNothing) {
  connect();
  ours().stream->hold(true);
  const std::string block(16 * 1024, 'x');
  std::size_t taken = 0;
  Result<void> sent;
  for (int i = 0; i < 5000 && (sent = client.stream->send(base::as_bytes(block))); ++i) {
    taken += block.size();
    ASSERT_TRUE(world->until([] { return true; }));
  }
  ASSERT_FALSE(sent) << "the sender got no error";
  EXPECT_EQ(sent.error().code, ErrorCode::kBusy);
  EXPECT_GT(client.stream->queued(), ByteStream::kMaxQueued - block.size());
  EXPECT_THAT(ours().heard, IsEmpty());
  ours().stream->hold(false);
  ASSERT_TRUE(world->until([&] { return ours().heard.size() >= taken; }));
  EXPECT_EQ(ours().heard.size(), taken);
  EXPECT_EQ(client.stream->queued(), 0u);
}

TEST_P(Listen, AListenerMayBeDestroyedInsideItsAccept) {
  std::unique_ptr<TcpListener> mortal;
  std::vector<std::unique_ptr<TcpStream>> kept;
  mortal = std::move(transports().listen_tcp({"127.0.0.1", 0}, [&](std::unique_ptr<TcpStream> stream) {
             kept.push_back(std::move(stream));
             mortal.reset();
             return TcpCallbacks{};
           })).value();
  client.connect(transports(), mortal->local());
  EXPECT_TRUE(world->until([&] { return client.connected == 1 && !mortal; }));
}

INSTANTIATE_TEST_SUITE_P(On, Listen, ::testing::Values(Where::kMachine, Where::kPollLoop, Where::kMemory),
                         [](const auto& where) { return name_of(where.param); });

/// The descriptor of this process whose socket is bound here and listens, or is connected to there; -1 = none.
int descriptor_of(const Endpoint& local, bool listens) {
  for (int descriptor = 3; descriptor < 1024; ++descriptor) {
    sockaddr_in address{};
    socklen_t size = sizeof address;
    int accepts = 0;
    socklen_t length = sizeof accepts;
    if (::getsockopt(descriptor, SOL_SOCKET, SO_ACCEPTCONN, &accepts, &length) == 0 && (accepts != 0) == listens &&
        ::getsockname(descriptor, reinterpret_cast<sockaddr*>(&address), &size) == 0 && address.sin_family == AF_INET &&
        ntohs(address.sin_port) == local.port)
      return descriptor;
  }
  return -1;
}

int option_of(int descriptor, int level, int option) {
  int value = -1;
  socklen_t size = sizeof value;
  ::getsockopt(descriptor, level, option, &value, &size);
  return value;
}

TEST(MachineListen, ADeadClientIsNoticedAndSmallSendsLeaveAtOnce) {
  MachineWorld world;
  Listening server;
  End client;
  ASSERT_TRUE(server.open(world.local, {"127.0.0.1", 0}));
  client.connect(world.local, server.listener->local());
  ASSERT_TRUE(world.until([&] { return server.accepted.size() == 1; }));
  const int descriptor = descriptor_of(server.listener->local(), false);
  ASSERT_GE(descriptor, 0);
  EXPECT_NE(option_of(descriptor, IPPROTO_TCP, TCP_NODELAY), 0);
  EXPECT_EQ(option_of(descriptor, IPPROTO_TCP, TCP_USER_TIMEOUT), 30000);
  EXPECT_NE(option_of(descriptor, SOL_SOCKET, SO_KEEPALIVE), 0);
  EXPECT_EQ(option_of(descriptor, IPPROTO_TCP, TCP_KEEPIDLE), 10);
}

/// Lets this process open no descriptor more, until this is destroyed.
class NoDescriptors {
 public:
  NoDescriptors() {
    ::getrlimit(RLIMIT_NOFILE, &before_);
    const int next = ::dup(0);
    ::close(next);
    const rlimit none{static_cast<rlim_t>(next), before_.rlim_max};
    ::setrlimit(RLIMIT_NOFILE, &none);
  }
  ~NoDescriptors() { ::setrlimit(RLIMIT_NOFILE, &before_); }

 private:
  rlimit before_{};
};

TEST(MachineListen, WithoutDescriptorsConnectionsWaitAndTheLoopDoesNotSpin) {
  MachineWorld world;
  Listening server;
  End client;
  ASSERT_TRUE(server.open(world.local, {"127.0.0.1", 0}));
  const auto waited = [&](Duration span) {
    const auto end = world.loop.scheduler().now() + span;
    return world.until([&] { return world.loop.scheduler().now() > end; });
  };
  waited(1ms);
  // Sanitizers need descriptors for what they check first: within, as little as possible is.
  std::clock_t busy = 0;
  std::size_t accepted = 0;
  client.connect(world.local, server.listener->local());
  {
    const NoDescriptors lack;
    waited(50ms);
    busy = std::clock();
    waited(300ms);
    busy = std::clock() - busy;
    accepted = server.accepted.size();
  }
  EXPECT_EQ(client.connected, 1) << "the system took the connection";
  EXPECT_EQ(accepted, 0u);
  EXPECT_LT(busy, CLOCKS_PER_SEC / 5);
  ASSERT_TRUE(world.until([&] { return server.accepted.size() == 1; }));
  EXPECT_THAT(server.failures, IsEmpty());
}

TEST(MachineListen, APortThatIsTakenAwayIsReported) {
  MachineWorld world;
  Listening server;
  ASSERT_TRUE(server.open(world.local, {"127.0.0.1", 0}));
  ::shutdown(descriptor_of(server.listener->local(), true), SHUT_RDWR);
  ASSERT_TRUE(world.until([&] { return !server.failures.empty(); }));
  ASSERT_THAT(server.failures, SizeIs(1));
  EXPECT_EQ(server.failures[0].code, ErrorCode::kIo);
  EXPECT_THAT(server.failures[0].text, HasSubstr(to_string(server.listener->local())));
}

TEST(MachineListen, WithoutALoopThereAreNoPorts) {
  EXPECT_EQ(LocalTransports().listen_tcp({"127.0.0.1", 0}, {}).error().code, ErrorCode::kUnsupported);
  EXPECT_EQ(MemoryTransports().listen_tcp({"127.0.0.1", 0}, {}).error().code, ErrorCode::kUnsupported);
}

TEST(MemoryListen, HostsHavePortsOfTheirOwnAndFindThemUnderLoopback) {
  MemoryWorld world;
  MemoryTransports one, other;
  one.join(world.net, "10.0.0.1");
  other.join(world.net, "10.0.0.2");
  Listening first, second;
  ASSERT_TRUE(first.open(one, {"127.0.0.1", 9002}));
  ASSERT_TRUE(second.open(other, {"127.0.0.1", 9002}));
  End client;
  client.connect(other, {"127.0.0.1", 9002});
  world.time.run_for(1s);
  EXPECT_EQ(client.connected, 1);
  EXPECT_THAT(first.accepted, IsEmpty());
  EXPECT_THAT(second.accepted, SizeIs(1));
  world.net.tcp.fail_listeners();
  world.time.run_for(1s);
  EXPECT_THAT(first.failures, SizeIs(1));
  EXPECT_THAT(second.failures, SizeIs(1));
  EXPECT_THAT(client.failures, IsEmpty()) << "connections live on";
  EXPECT_TRUE(first.open(one, {"127.0.0.1", 9002}));
}

}  // namespace
}  // namespace rubicon::transport
