#include "transport/mqtt_batch.h"

#include <gtest/gtest.h>

#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <string>

#include "base/bytes.h"

namespace rubicon::transport {
namespace {

using namespace std::chrono_literals;

/// Two ends of a connection that does not block.
class Batch : public ::testing::Test {
 protected:
  void SetUp() override { ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0, ends), 0); }
  void TearDown() override {
    ::close(ends[0]);
    ::close(ends[1]);
  }
  std::string read() const {
    std::string all(1 << 20U, 0);
    const auto count = ::recv(ends[1], all.data(), all.size(), 0);
    all.resize(count > 0 ? static_cast<std::size_t>(count) : 0);
    return all;
  }

  int ends[2] = {-1, -1};
  MqttBatch batch;
};

TEST_F(Batch, HasThePacketsOfVersion5) {
  MqttPublication one;
  one.topic = "a/b";
  one.payload = "21";
  one.retain = true;
  ASSERT_TRUE(batch.add(one, {}));
  one.retain = false;
  one.expiry = 1500ms;
  one.response_topic = "r";
  one.correlation = std::string("\0x", 2);
  ASSERT_TRUE(batch.add(one, {}));
  ASSERT_TRUE(batch.write(ends[0], nullptr));
  EXPECT_TRUE(batch.empty());
  // MQTT 5, section 3.3: type and flags, length, topic, properties (0x02, 0x08, 0x09), payload.
  EXPECT_EQ(base::to_hex(base::as_bytes(read())),
            "3108"
            "0003612f62"
            "00"
            "3231"
            "3016"
            "0003612f62"
            "0e"
            "0200000002"
            "08000172"
            "0900020078"
            "3231");
}

TEST_F(Batch, HasThePacketsOfVersion311) {
  MqttPublication one;
  one.topic = "a";
  one.payload = std::string(200, 'x');
  one.expiry = 1s;
  one.correlation = "not for it";
  ASSERT_TRUE(batch.add(one, {.version_5 = false}));
  ASSERT_TRUE(batch.write(ends[0], nullptr));
  EXPECT_EQ(read(), std::string("\x30\xcb\x01\0\1a", 6) + one.payload);
}

TEST_F(Batch, RetainsNothingWhereTheBrokerDoesNot) {
  ASSERT_TRUE(batch.add({"a", "1", true}, {.retains = false}));
  ASSERT_TRUE(batch.write(ends[0], nullptr));
  EXPECT_EQ(read().front(), '\x30');
}

TEST_F(Batch, LeavesOutWhatNoPropertyCanHold) {
  MqttPublication one;
  one.topic = "a";
  one.response_topic = "bad\n";
  one.correlation = std::string(65536, 'x');
  ASSERT_TRUE(batch.add(one, {}));
  ASSERT_TRUE(batch.write(ends[0], nullptr));
  EXPECT_EQ(read(), std::string("\x30\x04\0\1a\0", 6));
}

TEST_F(Batch, TakesNothingThatTheBrokerDoesNot) {
  // Header 2, topic 3, properties 1, payload 4.
  EXPECT_TRUE(batch.add({"a", "1234"}, {.largest_packet = 10}));
  EXPECT_FALSE(batch.add({"a", "12345"}, {.largest_packet = 10}));
  ASSERT_TRUE(batch.write(ends[0], nullptr));
  EXPECT_EQ(read().size(), 10U);
}

TEST_F(Batch, IsWrittenInPiecesToASocketThatIsFull) {
  const std::string large(3 << 20U, 'x');
  ASSERT_TRUE(batch.add({"a", large}, {}));
  std::string all;
  int pieces = 0;
  for (; !batch.empty(); ++pieces) {
    ASSERT_TRUE(batch.write(ends[0], nullptr));
    for (auto more = read(); !more.empty(); more = read()) all += more;
  }
  EXPECT_GT(pieces, 1);
  EXPECT_EQ(all.size(), 1 + 4 + 3 + 1 + large.size());
  ASSERT_TRUE(batch.add({"b", ""}, {}));
  ASSERT_TRUE(batch.write(ends[0], nullptr));
  EXPECT_EQ(read(), std::string("\x30\x04\0\1b\0", 6));
}

TEST_F(Batch, TellsThatTheConnectionEnded) {
  ASSERT_EQ(::shutdown(ends[1], SHUT_RDWR), 0);
  ASSERT_TRUE(batch.add({"a", "1"}, {}));
  EXPECT_FALSE(batch.write(ends[0], nullptr));
}

}  // namespace
}  // namespace rubicon::transport
