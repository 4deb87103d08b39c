#include "tuples/carry/forwarded_sets.h"

#include <gtest/gtest.h>

namespace rubicon::tuples::carry {
namespace {

struct Forwarded : testing::Test {
  ForwardedSets::Request& add(std::uint32_t owner, std::uint64_t request) {
    RemoteSet set;
    set.from = reader;
    set.request = request;
    return *sets.find(sets.add(OwnerId(owner), 0, 1, set, SteadyTime{}, WallTime(std::chrono::microseconds(1000))));
  }
  const OwnerId reader{101};
  ForwardedSets sets;
};

TEST_F(Forwarded, HaveTheNumberOfTheReaderUnlessItsOwnerWouldDropIt) {
  auto& first = add(7, 2);
  EXPECT_EQ(sets.wire_number(first, 0), 2U);
  EXPECT_EQ(sets.wire_number(first, 2), first.number) << "a reader that began to count again";
  EXPECT_EQ(sets.wire_number(first, 5000), 5001U);
  sets.sent(first, 2);
  auto& other = add(9, 2);
  EXPECT_EQ(sets.wire_number(other, 0), other.number) << "kernels count for each owner: two replies would be alike";
  EXPECT_EQ(sets.answered(reader, 1, 2), first.number);
  sets.take(first.number);
  EXPECT_EQ(sets.answered(reader, 1, 2), 0U);
  EXPECT_EQ(sets.wire_number(other, 0), 2U);
}

}  // namespace
}  // namespace rubicon::tuples::carry
