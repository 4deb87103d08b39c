#include "tuples/peis/own_messages.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/bytes.h"

namespace rubicon::tuples::peis {
namespace {

using namespace std::chrono_literals;

SubscribeAnnex subscription() {
  return {7, {1500us, 60s, 0.5, true}};
}

TEST(PeisAnnex, ASubscriptionHasTheseBytes) {
  EXPECT_EQ(base::to_hex(to_annex(subscription())),
            "52424331"          // RBC1
            "00000007"          // id
            "8000000005dc"      // passive, minimum
            "000003938700"      // maximum
            "3fe0000000000000"  // dead band
  );
  EXPECT_EQ(read_subscribe_annex(to_annex(subscription())), subscription());
}

TEST(PeisAnnex, ARemoteSetHasTheseBytes) {
  const SetAnnex set{0x0102030405060708, 5s, 9};
  EXPECT_EQ(base::to_hex(to_annex(set)),
            "5242433101020304050607080003"
            "0000004c4b40"
            "0000000000000009");
  EXPECT_EQ(read_set_annex(to_annex(set)), set);
}

TEST(PeisAnnex, WhatIsNotGivenStaysOpen) {
  const SetAnnex set{1, std::nullopt, std::nullopt};
  EXPECT_EQ(read_set_annex(to_annex(set)), set);
  const SetAnnex all{1, 5s, 9, true, true, true};
  EXPECT_EQ(read_set_annex(to_annex(all)), all);
  const SetAnnex none{1, Duration(0), 0};
  EXPECT_EQ(read_set_annex(to_annex(none)), none) << "zero is given: the tuple must not exist";
}

TEST(PeisAnnex, APushHasTheseBytes) {
  const PushAnnex gone{0x0102030405060708, EventKind::kExpired, true};
  EXPECT_EQ(base::to_hex(to_annex(gone)),
            "52424331"
            "00060000"
            "0102030405060708"
            "000000000000000000000000");
  for (const auto kind : {EventKind::kSet, EventKind::kDeleted, EventKind::kExpired}) {
    const PushAnnex push{7, kind, kind == EventKind::kSet};
    EXPECT_EQ(read_push_annex(to_annex(push)), push);
  }
  auto annex = to_annex(gone);
  annex[5] = 3;
  EXPECT_FALSE(read_push_annex(annex)) << "deleted and expired";
  annex[5] = 8;
  EXPECT_FALSE(read_push_annex(annex)) << "unknown flag";
  EXPECT_FALSE(read_push_annex(Annex{}));
}

TEST(PeisAnnex, DurationsAreLimitedAndRoundedDownToMicroseconds) {
  auto fields = subscription();
  fields.flow.minimum = Duration::max();
  fields.flow.maximum = 1999ns;
  auto read = read_subscribe_annex(to_annex(fields));
  ASSERT_TRUE(read);
  EXPECT_EQ(read->flow.minimum, kMaxAnnexDuration);
  EXPECT_EQ(read->flow.maximum, 1us);
  EXPECT_TRUE(read->flow.passive);
  fields.flow.minimum = -5s;
  read = read_subscribe_annex(to_annex(fields));
  EXPECT_EQ(read->flow.minimum, Duration(0));
}

TEST(PeisAnnex, ADeadBandThatIsNoneIsWrittenAsZero) {
  auto fields = subscription();
  for (const auto band : {-1.0, std::numeric_limits<double>::infinity(), std::nan("")}) {
    fields.flow.dead_band = band;
    EXPECT_EQ(read_subscribe_annex(to_annex(fields))->flow.dead_band, 0.0) << band;
  }
}

TEST(PeisAnnex, TheMemoryOfKernelsIsNotOfOurs) {
  EXPECT_FALSE(read_subscribe_annex(Annex{}));
  EXPECT_FALSE(read_set_annex(Annex{}));
  auto annex = to_annex(subscription());
  annex[0] = 'r';
  EXPECT_FALSE(read_subscribe_annex(annex));
}

TEST(PeisAnnex, FieldsOutOfRangeAreRefused) {
  const auto subscribe_with = [](std::size_t at, std::uint8_t byte) {
    auto annex = to_annex(subscription());
    annex[at] = byte;
    return read_subscribe_annex(annex).has_value();
  };
  EXPECT_FALSE(subscribe_with(7, 0)) << "id 0";
  EXPECT_FALSE(subscribe_with(14, 0x80)) << "maximum beyond the limit";
  EXPECT_FALSE(subscribe_with(20, 0xbf)) << "negative dead band";
  auto infinite = to_annex(subscription());
  infinite[20] = 0x7f;
  infinite[21] = 0xf0;
  EXPECT_FALSE(read_subscribe_annex(infinite));
  const auto set_with = [](std::size_t at, std::uint8_t byte) {
    auto annex = to_annex(SetAnnex{1, 5s, 9});
    annex[at] = byte;
    return read_set_annex(annex).has_value();
  };
  EXPECT_FALSE(set_with(11, 0)) << "request 0";
  EXPECT_FALSE(set_with(13, 32)) << "unknown flag";
  EXPECT_FALSE(set_with(14, 0x80)) << "time to live beyond the limit";
}

}  // namespace
}  // namespace rubicon::tuples::peis
