#include "model/value.h"

#include <gtest/gtest.h>

#include <bit>
#include <charconv>
#include <cmath>
#include <limits>
#include <random>

#include "model/point_tuples.h"
#include "rubicon/address.hpp"

namespace rubicon::model {
namespace {

TEST(Value, BooleansAreOnAndOff) {
  EXPECT_EQ(to_text(true), "on");
  EXPECT_EQ(to_text(false), "off");
}

TEST(Value, WholeNumbersAreDecimal) {
  EXPECT_EQ(to_text(std::int64_t{0}), "0");
  EXPECT_EQ(to_text(std::int64_t{-21}), "-21");
  EXPECT_EQ(to_text(std::int64_t{INT64_MAX}), "9223372036854775807");
  EXPECT_EQ(to_text(std::int64_t{INT64_MIN}), "-9223372036854775808");
}

TEST(Value, NumbersAreTheShortestThatReadBack) {
  EXPECT_EQ(to_text(21.5), "21.5");
  EXPECT_EQ(to_text(21.0), "21");
  EXPECT_EQ(to_text(0.1), "0.1");
  EXPECT_EQ(to_text(0.1 + 0.2), "0.30000000000000004");
  EXPECT_EQ(to_text(1e300), "1e+300");
}

TEST(Value, MinusZeroIsZero) {
  EXPECT_EQ(to_text(-0.0), "0");
}

TEST(Value, WhatIsNoNumberHasNoText) {
  EXPECT_EQ(to_text(std::numeric_limits<double>::quiet_NaN()), "");
  EXPECT_EQ(to_text(std::numeric_limits<double>::infinity()), "");
  EXPECT_EQ(to_text(-std::numeric_limits<double>::infinity()), "");
  EXPECT_EQ(to_text(Value()), "");
}

TEST(Value, EveryNumberReadsBackTheSame) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 10000; ++i) {
    const auto number = std::bit_cast<double>(random());
    if (!std::isfinite(number)) continue;
    const auto text = to_text(number);
    double read = 0;
    std::from_chars(text.data(), text.data() + text.size(), read);
    EXPECT_EQ(read, number) << text;
  }
}

TEST(Value, TextAndJsonStandAsTheyAre) {
  EXPECT_EQ(to_text(std::string("step-up")), "step-up");
  EXPECT_EQ(to_text(Json{R"({"x":1})"}), R"({"x":1})");
}

TEST(Value, OverwritesTheTextItIsWrittenTo) {
  std::string out = "something longer than the value";
  to_text(7.25, out);
  EXPECT_EQ(out, "7.25");
  to_text(Value(), out);
  EXPECT_EQ(out, "");
}

TEST(Value, OnlyJsonHasTheMediaTypeOfJson) {
  EXPECT_EQ(media_type(Json{"1"}), "application/json");
  EXPECT_EQ(media_type(std::string("{}")), "text/plain");
  EXPECT_EQ(media_type(1.5), "text/plain");
  EXPECT_EQ(media_type(Value()), "text/plain");
}

TEST(Address, IslandsAreNumbersThatMotesCanCarry) {
  EXPECT_FALSE(is_island(kNoOwner));
  EXPECT_TRUE(is_island(OwnerId{1}));
  EXPECT_TRUE(is_island(OwnerId{65532}));
  EXPECT_FALSE(is_island(OwnerId{65533}));
  EXPECT_FALSE(is_island(OwnerId{70000}));
}

TEST(Address, IsWrittenWithSlashes) {
  EXPECT_EQ(to_string(Address{OwnerId{6541}, "wsn-1", "7"}), "6541/wsn-1/7");
}

TEST(Quality, HasAWordForEach) {
  EXPECT_EQ(to_string(Quality::kNetworkDown), "network-down");
  EXPECT_EQ(to_string(Quality::kDeviceOffline), "device-offline");
  EXPECT_EQ(to_string(Quality::kBad), "bad");
  EXPECT_EQ(to_string(Quality::kUnknown), "unknown");
  EXPECT_EQ(to_string(Quality::kStale), "stale");
  EXPECT_EQ(to_string(Quality::kStored), "stored");
  EXPECT_EQ(to_string(Quality::kAssumed), "assumed");
  EXPECT_EQ(to_string(Quality::kGood), "good");
}

}  // namespace
}  // namespace rubicon::model
