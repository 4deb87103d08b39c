#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/write.hpp>
#include <memory>
#include <vector>

#include "networks/knx/line/tunnel_line.h"
#include "support/knx_server.h"
#include "transport/worlds.h"

namespace rubicon::networks::knx::line {
namespace {

using namespace std::chrono_literals;
using boost::asio::ip::tcp;
using transport::Endpoint;
using transport::TcpStream;

/// Hands what comes on a port of the machine's loopback to a server on a network of memory, and back.
class Bridge {
 public:
  Bridge(boost::asio::io_context& context, transport::MemoryNet& net, Endpoint server)
      : net_(net), server_(std::move(server)), acceptor_(context, {boost::asio::ip::address_v4::loopback(), 0}) {
    accept();
  }
  std::uint16_t port() const { return acceptor_.local_endpoint().port(); }
  /// Everybody is hung up on.
  void cut() { ends_.clear(); }
  std::size_t connections() const { return ends_.size(); }

  bool deaf = false;  ///< what comes is not read: it stays in the kernel

 private:
  struct End {
    explicit End(tcp::socket s) : socket(std::move(s)) {}
    tcp::socket socket;
    std::unique_ptr<TcpStream> inner;
    std::array<std::uint8_t, 4096> buffer{};
  };

  void accept() {
    acceptor_.async_accept([this](auto error, tcp::socket socket) {
      if (error) return;
      const auto end = std::make_shared<End>(std::move(socket));
      ends_.push_back(end);
      join(end);
      accept();
    });
  }
  void join(const std::shared_ptr<End>& end) {
    transport::TcpCallbacks calls;
    calls.received = [raw = end.get()](ByteView bytes) {
      boost::system::error_code ignored;
      boost::asio::write(raw->socket, boost::asio::buffer(bytes.data(), bytes.size()), ignored);
    };
    calls.failed = [](const Error&) {};
    transport::TcpOptions options;
    options.remote = server_;
    end->inner = std::move(net_.tcp.open("10.0.0.7", options, std::move(calls)).value());
    read(end);
  }
  void read(const std::shared_ptr<End>& end) {
    if (deaf) return;
    end->socket.async_read_some(boost::asio::buffer(end->buffer),
                                [this, weak = std::weak_ptr(end)](auto error, auto n) {
                                  const auto one = weak.lock();
                                  if (!one) return;
                                  if (error) return void(std::erase(ends_, one));
                                  EXPECT_TRUE(one->inner->send(ByteView(one->buffer).first(n)));
                                  read(one);
                                });
  }

  transport::MemoryNet& net_;
  Endpoint server_;
  tcp::acceptor acceptor_;
  std::vector<std::shared_ptr<End>> ends_;
};

/// The tunnel over true sockets, against the server that was written from the specification alone: Debian's knxd has no
/// TCP.
class TunnelOverTcp : public ::testing::Test {
 protected:
  TunnelOverTcp() {
    options.host = "127.0.0.1";
    options.port = bridge.port();
    options.via = TunnelOptions::Via::kTcp;
    options.limits.rate = 0;
    LineCallbacks calls;
    calls.received = [this](const wire::Telegram& telegram) { received.push_back(telegram); };
    calls.failed = [this](Error why) {
      failures.push_back(std::move(why));
      reopening = time().after(50ms, [this] { EXPECT_TRUE(line->open()); });
    };
    line = std::make_unique<TunnelLine>(options, time(), world.local, std::move(calls));
  }
  Scheduler& time() { return world.loop.scheduler(); }
  bool up() const { return line->state().phase == LineState::Phase::kUp; }
  void connect() {
    ASSERT_TRUE(line->open());
    ASSERT_TRUE(world.until([&] { return up(); })) << line->state().reason;
  }
  void write(std::uint8_t value, Duration lives = 1min) {
    wire::Telegram telegram;
    telegram.destination = wire::GroupAddress(0x0a07);
    telegram.payload = {{1, value}, false};
    line->send(telegram, time().now() + lives,
               [this](SendOutcome outcome, std::string_view) { outcomes.push_back(outcome); });
  }

  transport::MachineWorld world;
  transport::MemoryNet net{world.loop.scheduler()};
  support::KnxServer server{world.loop.scheduler(), net};
  Bridge bridge{world.loop.context(), net, {"10.0.0.9", 3671}};
  TunnelOptions options;
  std::vector<wire::Telegram> received;
  std::vector<Error> failures;
  std::vector<SendOutcome> outcomes;
  Timer reopening;
  std::unique_ptr<TunnelLine> line;
};

TEST_F(TunnelOverTcp, TelegramsGoBothWaysInOrder) {
  connect();
  EXPECT_EQ(to_string(line->state().own), "1.1.200");
  for (std::uint8_t i = 0; i < 200; ++i) {
    write(i);
    server.inject(0x1101, 0x0a08, 0x80, {2, i});
  }
  ASSERT_TRUE(world.until([&] { return outcomes.size() == 200 && received.size() == 200; }));
  EXPECT_THAT(outcomes, ::testing::Each(SendOutcome::kSent));
  ASSERT_EQ(server.heard().size(), 200U);
  for (std::uint8_t i = 0; i < 200; ++i) {
    EXPECT_EQ(server.heard()[i].tpdu.back(), i);
    EXPECT_EQ(received[i].payload.bytes.back(), i);
  }
  line.reset();
  EXPECT_TRUE(world.until([&] { return server.channels().empty() && bridge.connections() == 0; }));
  EXPECT_EQ(server.counters.disconnects, 1U);
}

TEST_F(TunnelOverTcp, ABrokenConnectionIsReopenedAndUnconfirmedTelegramsAreSentOnceMore) {
  connect();
  server.confirms = false;
  write(1);
  ASSERT_TRUE(world.until([&] { return server.heard().size() == 1; }));
  server.confirms = true;
  bridge.cut();
  ASSERT_TRUE(world.until([&] { return outcomes.size() == 1; }));
  EXPECT_EQ(outcomes[0], SendOutcome::kSent);
  EXPECT_EQ(server.heard().size(), 2U);
  EXPECT_EQ(failures.size(), 1U);
}

TEST_F(TunnelOverTcp, ADeadPeerIsClosedAndGetsNoFurtherTelegrams) {
  connect();
  bridge.deaf = true;
  write(0, 1s);  // this one is read still
  ASSERT_TRUE(world.until([&] { return outcomes.size() == 1; }));
  write(1, 1s);
  write(2, 1s);
  ASSERT_TRUE(world.until([&] { return !failures.empty(); }));
  EXPECT_NE(failures[0].text.find("stopped responding"), std::string::npos) << failures[0].text;
  ASSERT_TRUE(world.until([&] { return outcomes.size() == 3; }));
  EXPECT_THAT(outcomes, ::testing::ElementsAre(SendOutcome::kSent, SendOutcome::kExpired, SendOutcome::kLost));
  EXPECT_EQ(server.heard().size(), 1U);
}

}  // namespace
}  // namespace rubicon::networks::knx::line
