#include "model/type_names.h"

#include <gtest/gtest.h>

namespace rubicon::model {
namespace {

TEST(PropertyAlias, SamplingRateIsRateInWholeKeysAndShortNames) {
  EXPECT_EQ(without_alias("proxy.wsn-1.7.property.sampling-rate.command"), "proxy.wsn-1.7.property.rate.command");
  EXPECT_EQ(without_alias("proxy.wsn-1.7.property.sampling-rate"), "proxy.wsn-1.7.property.rate");
  EXPECT_EQ(without_alias("proxy.*.*.property.sampling-rate.value"), "proxy.*.*.property.rate.value");
  EXPECT_EQ(without_alias("wsn-1.7.sampling-rate"), "wsn-1.7.rate");
  EXPECT_EQ(without_alias("kitchen.sampling-rate"), "kitchen.rate");
}

TEST(PropertyAlias, EveryOtherKeyStaysAsItIs) {
  for (const auto* key : {"", "sampling-rate", "proxy.wsn-1.7.sensor.sampling-rate.value", "sampling-rate.7.light-1",
                          "proxy.sampling-rate.7.property.rate.value", "proxy.wsn-1.7.property.rate.sampling-rate",
                          "wsn-1.7.sampling-rate-2"})
    EXPECT_EQ(without_alias(key), key);
}

}  // namespace
}  // namespace rubicon::model
