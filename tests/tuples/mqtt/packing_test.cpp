#include "tuples/mqtt/messages.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tuples/mqtt/site.h"

namespace rubicon::tuples::mqtt {
namespace {

using namespace std::chrono_literals;

TEST(PackingTest, LeavesSmallAndDenseEntriesAsTheyAre) {
  Packing packing;
  const std::string small(Packing::kMinPacked - 1, 'x');
  EXPECT_FALSE(packing.packed(base::as_bytes(small)));
  Bytes random(5000);
  std::mt19937 dice(1);
  for (auto& byte : random) byte = static_cast<std::uint8_t>(dice());
  EXPECT_FALSE(packing.packed(random));
  Bytes into;
  EXPECT_EQ(base::as_text(packing.unpacked(base::as_bytes(small), into).value()), small);
  EXPECT_TRUE(into.empty());
}

TEST(PackingTest, GivesBackWhatItPacked) {
  Packing packing;
  const auto text = noise(Packing::kMaxUnpacked);
  const auto packed = packing.packed(base::as_bytes(text));
  ASSERT_TRUE(packed);
  EXPECT_LT(packed->size(), text.size());
  Bytes into;
  EXPECT_EQ(base::as_text(packing.unpacked(*packed, into).value()), text);
}

TEST(PackingTest, RefusesWhatIsDamagedOrTooLarge) {
  Packing packing;
  Bytes into;
  const std::string text(5000, 'x');
  auto packed = packing.packed(base::as_bytes(text)).value();
  for (std::size_t size = 1; size < packed.size(); ++size)
    EXPECT_FALSE(packing.unpacked(ByteView(packed).first(size), into)) << size;
  auto wrong = packed;
  ++wrong[5];  // the content size (RFC 8878, 3.1.1.1.4)
  EXPECT_FALSE(packing.unpacked(wrong, into));
  // 4 GiB of content, announced in eight bytes by a frame of one segment
  const Bytes bomb{0x28, 0xb5, 0x2f, 0xfd, 0xe0, 0, 0, 0, 0, 1, 0, 0, 0, 0x03, 0, 0, 0};
  EXPECT_EQ(packing.unpacked(bomb, into).error().code, ErrorCode::kInvalid);
  // content of unknown size
  const Bytes unknown{0x28, 0xb5, 0x2f, 0xfd, 0x00, 0x58, 0x03, 0, 0, 0x78};
  EXPECT_EQ(packing.unpacked(unknown, into).error().code, ErrorCode::kInvalid);
}

/// What the broker carries for a robot that reads the descriptions of 200 devices.
TEST(PackingTest, AListOfDevicesCostsAFifthOfItsText) {
  VirtualScheduler time;
  transport::MemoryNet net{time};
  transport::MqttBroker broker{net, kBroker};
  Site hall(time, net, kHall, "10.0.0.2", options_at({kBroker}));
  Site robot(time, net, kRobot, "10.0.0.3", options_at({kBroker}));
  std::size_t text = 0, bytes = 0, came = 0;
  for (int i = 0; i < 200; ++i) {
    const auto key = fmt::format("proxy.dummy-1.room-{}.description", i);
    const auto value = fmt::format(
        R"({{"name":"Room {}","model":"Dummy","address":"{}","capabilities":["sample"],"sensors":["temperature-1","light-1"],"actuators":["lamp-1"],"properties":["rate"]}})",
        i, i);
    text += key.size() + value.size();
    EXPECT_TRUE(hall.space->set(key, value));
  }
  time.run_for(2s);
  broker.heard = [&](const transport::MqttBroker::Publication& one) { bytes += one.payload.size(); };
  const auto list = robot.space->subscribe(pattern("1:proxy.*.*.description"), {}, [&](const Event&) { ++came; });
  time.run_for(5s);
  EXPECT_EQ(came, 200U);
  EXPECT_LT(bytes, text / 5);
}

}  // namespace
}  // namespace rubicon::tuples::mqtt
