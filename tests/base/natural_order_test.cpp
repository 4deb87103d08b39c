#include "base/natural_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

namespace rubicon::base {
namespace {

TEST(NaturalOrder, RunsOfDigitsCountAsNumbers) {
  std::vector<std::string> ids{"wsn-10", "1_0_12", "wsn-2", "wsn", "1_0_7", "wsn-2a", "18446744073709551616",
                               "7",      "07"};
  std::sort(ids.begin(), ids.end(), natural_less);
  EXPECT_EQ(ids, (std::vector<std::string>{"1_0_7", "1_0_12", "07", "7", "18446744073709551616", "wsn", "wsn-2",
                                           "wsn-2a", "wsn-10"}));
}

TEST(NaturalOrder, NothingIsLessThanItself) {
  for (const auto* id : {"", "7", "a7b"}) EXPECT_FALSE(natural_less(id, id));
}

}  // namespace
}  // namespace rubicon::base
