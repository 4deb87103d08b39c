#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "tuples/peis/link_to_a_kernel.h"

namespace rubicon::tuples::peis {
namespace {

constexpr int kKeys = 50;

class SlowKernel : public LinkToAKernel {
 protected:
  SlowKernel() {
    kernel.each_step = 9;
    subscribe("b.*");
    world.run(1s);
  }
  void set_for(Duration span, int each_millisecond) {
    for (auto left = span; left > Duration(0); left -= 1ms) {
      for (int i = 0; i < each_millisecond; ++i, ++last)
        EXPECT_TRUE(space->set("b.k" + std::to_string(last % kKeys), std::to_string(last)));
      world.run(1ms);
    }
  }
  int last = 0;
};

TEST_F(SlowKernel, GetsAsManyAsItTakesAndHardlyOneTwice) {
  set_for(10s, 3);
  const auto taken_in = kernel.of(Port::kPush).size();
  const auto whole = pushed().size();
  EXPECT_GT(whole, 8000u) << "of the 9000 packages that it can take";
  EXPECT_LT(taken_in - whole, whole / 50) << "sent again in vain";
}

TEST_F(SlowKernel, HasTheNewestValueOfEachKeySoonAfterTheLastOne) {
  set_for(5s, 20);
  world.run(500ms);
  std::map<std::string, std::string> values;
  for (const auto& push : pushed()) values[push.key] = push.data;
  for (int i = last - kKeys; i < last; ++i)
    EXPECT_EQ(values["b.k" + std::to_string(i % kKeys)], c_string(std::to_string(i)));
}

}  // namespace
}  // namespace rubicon::tuples::peis
