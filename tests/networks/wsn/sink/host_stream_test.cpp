#include <gmock/gmock.h>

#include "networks/wsn/sink/sink_fixture.h"

namespace rubicon::networks::wsn::sink {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

/// A sink behind a host's name.
using HostStreamTest = SerialSinkFixture;

TEST_F(HostStreamTest, IsNoLineIfNoServerListens) {
  options.source = parse_source("network@10.0.0.9:1").value();
  reopens = false;
  make();
  open();
  time.run_for(1s);
  ASSERT_EQ(failures.size(), 1U);
  EXPECT_THAT(failures[0].text, HasSubstr("network@10.0.0.9:1"));
  EXPECT_EQ(phase(), Phase::kOff);
}

TEST_F(HostStreamTest, TriesEveryAddressOfAHost) {
  net.name("sink.example", {"10.0.0.7", "10.0.0.9"});
  options.source = parse_source("network@sink.example:19202").value();
  connect();
  EXPECT_THAT(failures, IsEmpty());
  EXPECT_EQ(mote.connections, 1U);
}

TEST_F(HostStreamTest, SaysThatAHostHasNoAddress) {
  options.source = parse_source("network@nowhere.example:19202").value();
  reopens = false;
  make();
  open();
  time.run_for(1s);
  ASSERT_EQ(failures.size(), 1U);
  EXPECT_THAT(failures[0].text, HasSubstr(": host nowhere.example cannot be found"));
}

TEST_F(HostStreamTest, SaysWhichHostItWasWhereAnAddressDoesNotAnswer) {
  net.name("connect", {"10.0.0.9"});
  options.source = parse_source("network@connect:1").value();
  reopens = false;
  make();
  open();
  time.run_for(1s);
  ASSERT_EQ(failures.size(), 1U);
  EXPECT_THAT(failures[0].text, HasSubstr("network@connect:1: connect: TCP 10.0.0.9:1"));
}

/// The transports of this host, without UDP.
class TcpAlone final : public transport::Transports {
 public:
  explicit TcpAlone(transport::Transports& host) : host_(host) {}
  Result<std::unique_ptr<transport::FileSource>> open_file(const std::string& path) override {
    return host_.open_file(path);
  }
  Result<std::unique_ptr<transport::UdpSocket>> open_udp(const transport::UdpOptions&,
                                                         transport::UdpCallbacks) override {
    ADD_FAILURE() << "a UDP socket was asked for";
    return fail(ErrorCode::kIo, "no descriptors left");
  }
  Result<std::unique_ptr<transport::TcpStream>> open_tcp(const transport::TcpOptions& to,
                                                         transport::TcpCallbacks calls) override {
    return host_.open_tcp(to, std::move(calls));
  }
  std::unique_ptr<transport::Lookup> look_up(const std::string& host, transport::LookupDone done) override {
    return host_.look_up(host, std::move(done));
  }

 private:
  transport::Transports& host_;
};

TEST_F(HostStreamTest, BindsNoPortToConnect) {
  TcpAlone alone(transports);
  sink = std::make_unique<SerialSink>(options, time, alone, calls(), std::uint8_t{0});
  open();
  time.run_for(1s);
  EXPECT_EQ(phase(), Phase::kUp);
}

TEST_F(HostStreamTest, CannotBeOpenedWhereThereAreNoSockets) {
  transport::MemoryTransports alone;
  sink = std::make_unique<SerialSink>(options, time, alone, calls(), std::uint8_t{0});
  const auto opened = sink->open();
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, ErrorCode::kUnsupported);
}

}  // namespace
}  // namespace rubicon::networks::wsn::sink
