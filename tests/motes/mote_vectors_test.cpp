#include <gtest/gtest.h>

#include "motes/mote_codec.h"
#include "motes/mote_vectors.h"

namespace rubicon::motes {
namespace {

class MoteVectors : public testing::Test {
 protected:
  void SetUp() override {
    for (const Vector& vector : shared_vectors()) {
      for (const Bytes& packet : packets_of(vector)) packets_.emplace_back(vector.name, packet);
    }
    if (packets_.empty()) GTEST_SKIP() << "no ../shared/data/motes/vectors.tsv beside the source tree";
  }

  std::vector<std::pair<std::string, Bytes>> packets_;
};

TEST_F(MoteVectors, AreAllDecodedAndEncodeToTheSameBytes) {
  EXPECT_EQ(packets_.size(), 79u);
  for (const auto& [name, bytes] : packets_) {
    const auto packet = decode_packet(bytes);
    ASSERT_TRUE(packet.has_value()) << name;
    EXPECT_EQ(encode_packet(*packet), bytes) << name;
    if (packet->is(AmType::kConfig)) {
      const auto config = decode_config(packet->payload);
      ASSERT_TRUE(config.has_value()) << name;
      EXPECT_EQ(config->command, kSetIslandId) << name;
      EXPECT_EQ(base::to_hex(encode_config(*config)), base::to_hex(packet->payload)) << name;
    }
  }
}

TEST_F(MoteVectors, HoldRecordsThatEncodeToTheirOwnFront) {
  std::size_t records = 0;
  for (const auto& [name, bytes] : packets_) {
    const auto packet = decode_packet(bytes);
    if (!packet->is(AmType::kNetMessage) || packet->payload.size() < 15) continue;
    const auto message = decode_net(packet->payload);
    ASSERT_TRUE(message.has_value()) << name;
    EXPECT_EQ(base::to_hex(encode_net(*message)), base::to_hex(packet->payload)) << name;
    const auto record = decode_record(*message);
    // Commands that were cut short on purpose.
    if (name == "avr-cmd-2" || name == "avr-cmd-4") {
      EXPECT_FALSE(record.has_value()) << name;
      continue;
    }
    ASSERT_TRUE(record.has_value()) << name << ": " << record.error().text;
    const Bytes encoded = encode_record(*record);
    ASSERT_LE(encoded.size(), message->record.size()) << name;
    EXPECT_EQ(base::to_hex(encoded), base::to_hex(ByteView(message->record).first(encoded.size()))) << name;
    ++records;
  }
  EXPECT_GT(records, 30u);
}

TEST_F(MoteVectors, SurviveEveryPrefixAndEverySingleByteCorruption) {
  const TypeCatalogue types;
  std::size_t decoded = 0;
  for (const auto& [name, bytes] : packets_) {
    MoteCodec codec(types, {});
    for (std::size_t length = 0; length <= bytes.size(); ++length)
      decoded += codec.decode(ByteView(bytes).first(length)).has_value() ? 1u : 0u;
    for (std::size_t at = 0; at < std::min<std::size_t>(bytes.size(), 40); ++at) {
      for (const int change : {0x01, 0x10, 0x7f, 0x80, 0xff}) {
        Bytes damaged = bytes;
        damaged[at] = static_cast<std::uint8_t>(damaged[at] ^ change);
        decoded += codec.decode(damaged).has_value() ? 1u : 0u;
      }
    }
  }
  EXPECT_GT(decoded, packets_.size());
}

}  // namespace
}  // namespace rubicon::motes
