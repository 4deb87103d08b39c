#include "motes/framing.h"
#include "networks/wsn/wsn_fixture.h"

namespace rubicon::networks::wsn {
namespace {

using ::testing::ElementsAre;
using ::testing::Ge;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr std::size_t kTypeAt = 7;

/// A packet of a client that carries a number.
Bytes numbered(std::uint16_t number) {
  return {0, 0, 1, 0, 0, 2, 0, 0x1c, static_cast<std::uint8_t>(number >> 8), static_cast<std::uint8_t>(number & 0xff)};
}

/// Acknowledges and remembers everything. Destroying it pulls the cable: its port does not answer.
class AckingSink {
 public:
  AckingSink(transport::MemoryNet& net, const transport::Endpoint& at) {
    listener_ = net.tcp.listen(at, [this](auto stream) {
      stream_ = std::move(stream);
      transport::StreamCallbacks calls;
      calls.received = [this](ByteView bytes) { take(bytes); };
      return calls;
    });
  }

  std::vector<Bytes> executed;

 private:
  void take(ByteView bytes) {
    while (const auto frame = reader_.next(bytes)) {
      if (frame->protocol != motes::kHdlcAckedPacket) continue;
      executed.emplace_back(frame->packet.begin(), frame->packet.end());
      std::ignore = stream_->send(motes::hdlc_ack(frame->sequence));
    }
  }

  std::unique_ptr<transport::MemoryListener> listener_;
  std::unique_ptr<transport::TcpStream> stream_;
  motes::HdlcReader reader_;
};

/// Other programs at a shared sink whose cable is pulled.
class SinkAway : public MoteNetwork {
 protected:
  void plug() { sink = std::make_unique<AckingSink>(host.net, transport::Endpoint{"127.0.0.1", 19202}); }
  std::unique_ptr<transport::TcpStream> client() {
    auto stream = std::move(host.transports().open_tcp({{"127.0.0.1", 9002}}, {})).value();
    EXPECT_TRUE(stream->send(motes::kForwarderHello));
    run(50ms);
    return stream;
  }
  static void say(transport::TcpStream& stream, std::uint16_t number) {
    EXPECT_TRUE(stream.send(motes::forwarder_packet(numbered(number))));
  }
  /// Packets of clients that the sink executed.
  std::vector<int> executed() const {
    std::vector<int> numbers;
    for (const auto& packet : sink->executed)
      if (packet[kTypeAt] == 0x1c) numbers.push_back(packet[8] << 8 | packet[9]);
    return numbers;
  }

  std::unique_ptr<AckingSink> sink;
};

TEST_F(SinkAway, OldPacketsOfClientsAreNotExecuted) {
  plug();
  open();
  run(1s);
  auto gone = client();
  auto stays = client();
  say(*stays, 1);
  run(1s);
  EXPECT_THAT(executed(), ElementsAre(1));
  sink.reset();
  run(1s);
  for (std::uint16_t number = 1000; number < 1400; ++number) say(*gone, number);
  run(100ms);
  for (std::uint16_t number = 2000; number < 2400; ++number) say(*stays, number);
  run(100ms);
  gone.reset();
  run(70s);
  plug();
  run(30s);
  ASSERT_THAT(sink->executed, SizeIs(Ge(1U))) << "it is back, and got its island id";
  EXPECT_THAT(executed(), IsEmpty());
  EXPECT_EQ(counter("expired") + counter("share-dropped-expired"), 800U);
  say(*stays, 2);
  run(1s);
  EXPECT_THAT(executed(), ElementsAre(2));
}

}  // namespace
}  // namespace rubicon::networks::wsn
