#include "base/compare_text.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
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

/// Eight digits before a letter of an address are not a number there. The page keeps the same order
/// (web/test/text.test.ts).
TEST(NaturalOrder, IeeeAddressesAreTexts) {
  std::ifstream file(RUBICON_SOURCE_DIR "/tests/cases/order/ids.txt");
  std::vector<std::string> sorted;
  for (std::string id; std::getline(file, id);) sorted.push_back(id);
  ASSERT_GT(sorted.size(), 20u);
  auto ids = sorted;
  std::reverse(ids.begin(), ids.end());
  std::sort(ids.begin(), ids.end(), natural_less);
  EXPECT_EQ(ids, sorted);
}

/// Numbers of many digits beside addresses: a sort needs one order of all.
TEST(NaturalOrder, IsAnOrder) {
  const std::vector<std::string> all{"5",
                                     "500000000000000",
                                     "1000000000000000",
                                     "100000000000000a",
                                     "0x100000000000000a",
                                     "2a",
                                     "a",
                                     "zz",
                                     ".",
                                     "ab00000000000000",
                                     "",
                                     "07",
                                     "7"};
  for (const auto& a : all) {
    for (const auto& b : all) {
      EXPECT_EQ(natural_less(a, b) + natural_less(b, a), a == b ? 0 : 1) << a << ' ' << b;
      for (const auto& c : all) {
        EXPECT_TRUE(!natural_less(a, b) || !natural_less(b, c) || natural_less(a, c)) << a << ' ' << b << ' ' << c;
      }
    }
  }
}

TEST(NaturalOrder, NothingIsLessThanItself) {
  for (const auto* id : {"", "7", "a7b"}) EXPECT_FALSE(natural_less(id, id));
}

}  // namespace
}  // namespace rubicon::base
