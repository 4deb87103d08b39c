#include "tuples/peis/translation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "tuples/peis/kernel_state.h"

namespace rubicon::tuples::peis {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(PeisPatterns, OursBecomeOneKeyForEachDepth) {
  EXPECT_THAT(to_kernel_patterns("a.b"), ElementsAre("a.b"));
  EXPECT_THAT(to_kernel_patterns("a.*"), ElementsAre("a.*"));
  EXPECT_THAT(to_kernel_patterns("**"), ElementsAre(""));
  EXPECT_THAT(to_kernel_patterns("a.b.c.d.e.**"), ElementsAre("a.b.c.d.e", "a.b.c.d.e.*", "a.b.c.d.e.*.*"));
  EXPECT_THAT(to_kernel_patterns("a.b.c.d.e.f.g.h"), IsEmpty()) << "no kernel has such a key";
  EXPECT_THAT(to_kernel_patterns("a.b.c.d.e.f.g.h.**"), IsEmpty());
  EXPECT_THAT(to_kernel_patterns(std::string(125, 'k') + ".**"),
              ElementsAre(std::string(125, 'k'), std::string(125, 'k') + ".*"));
}

TEST(PeisPatterns, TheirsBecomePatterns) {
  EXPECT_EQ(*from_kernel_pattern(""), "**") << "all depths";
  EXPECT_EQ(*from_kernel_pattern("*"), "*") << "depth one";
  EXPECT_EQ(*from_kernel_pattern("Demo.*.value"), "Demo.*.value");
  EXPECT_FALSE(from_kernel_pattern("a*.b")) << "kernels refuse it too";
  EXPECT_FALSE(from_kernel_pattern("a.**"));
  EXPECT_FALSE(from_kernel_pattern("a b"));
  EXPECT_FALSE(from_kernel_pattern("7:a"));
}

TEST(PeisPatterns, KeysBeyondTheLimitsAreNamedWithThem) {
  EXPECT_TRUE(check_peis_key("a.b.c.d.e.f.g"));
  EXPECT_THAT(check_peis_key("a.b.c.d.e.f.g.h").error().text, HasSubstr("'a.b.c.d.e.f.g.h' has 8 parts"));
  EXPECT_TRUE(check_peis_key(std::string(127, 'k')));
  EXPECT_THAT(check_peis_key(std::string(128, 'k')).error().text, HasSubstr("128 characters, PEIS kernels allow 127"));
}

TEST(PeisPatterns, MatchWithoutCaseAndTakeTheSpellingOfTheKey) {
  EXPECT_TRUE(matches_folded("Demo.*.VALUE", "demo.Temp.value"));
  EXPECT_FALSE(matches_folded("demo.*", "demo.a.b"));
  EXPECT_TRUE(matches_folded("demo.**", "DEMO.a.b"));
  EXPECT_EQ(spelled_as("demo.*.VALUE", "Demo.Temp.value"), "Demo.*.value");
  EXPECT_EQ(spelled_as("demo.**", "Demo.Temp.value"), "Demo.**");
}

TEST(PeisValues, TextHasOneNulMore) {
  const auto text = to_wire("21.5", "text/plain");
  EXPECT_EQ(text.encoding, Encoding::kAscii);
  EXPECT_EQ(text.data, std::string("21.5\0", 5));
  EXPECT_EQ(to_wire("{}", "application/json").encoding, Encoding::kAscii);
  EXPECT_EQ(to_wire("", "application/x").data, std::string("\0", 1)) << "kernels drop tuples without data";
  const auto binary = to_wire("\xff", "application/x");
  EXPECT_EQ(binary.encoding, Encoding::kBinary);
  EXPECT_EQ(binary.data, "\xff");
  EXPECT_EQ(to_wire(std::string("a\0", 2), "application/x").data, std::string("a\0", 2));
}

TEST(PeisValues, ComeBackAsTheyWere) {
  for (const auto* type : {"text/plain", "application/x"}) {
    for (const auto& value : {std::string(), std::string("a"), std::string("a\0", 2), std::string("\xff\0", 2)}) {
      const auto wire = to_wire(value, type);
      EXPECT_EQ(from_wire(wire.encoding, wire.data), value);
    }
  }
}

TEST(PeisValues, OfKernelsLoseOneNulUnlessTheyAreBinaryUnderAnOldEncoding) {
  EXPECT_EQ(from_kernel(Encoding::kAscii, std::string_view("on\0", 3), "text/plain"), "on");
  EXPECT_EQ(from_kernel(Encoding::kAscii, "on", "text/plain"), "on");
  const std::string_view binary("\x01\0\x02\0", 4);
  EXPECT_EQ(from_kernel(Encoding::kAscii, binary, "image/x"), binary);
  EXPECT_EQ(from_kernel(Encoding::kBinary, binary, "image/x"), binary);
  EXPECT_EQ(from_kernel(Encoding::kBinary, std::string_view("\0", 1), "image/x"), "") << "an empty value";
  EXPECT_EQ(appended(Encoding::kAscii, std::string_view("a\0", 2), std::string_view(";b\0", 3)),
            std::string("a;b\0", 4));
  EXPECT_EQ(appended(Encoding::kBinary, std::string_view("a\0", 2), "b"), std::string("a\0b", 3));
}

TupleView version(std::string_view key, std::uint64_t sequence) {
  TupleView view;
  view.key = key;
  view.sequence = sequence;
  view.write_time = WallTime(std::chrono::seconds(sequence));
  return view;
}

TEST(PeisOwnKeys, NumbersAreEqualForEqualVersionsAndRiseElse) {
  OwnKeys keys;
  ASSERT_TRUE(keys.add("a"));
  EXPECT_EQ(keys.number_of(version("a", 3)), 2u) << "theirs begin at 0";
  EXPECT_EQ(keys.number_of(version("a", 3)), 2u) << "another kernel";
  EXPECT_EQ(keys.number_of(version("a", 7)), 6u);
  EXPECT_EQ(keys.number_of(TupleGone{EventKind::kDeleted, "a", 7}), 7u);
  ASSERT_TRUE(keys.remove("a", SteadyTime(1s)));
  ASSERT_TRUE(keys.add("A"));
  EXPECT_EQ(keys.number_of(version("A", 1)), 8u) << "one tuple to kernels";
}

TEST(PeisOwnKeys, NumbersOfAKeyThatWasForgottenRiseOn) {
  OwnKeys keys;
  ASSERT_TRUE(keys.add("a"));
  EXPECT_EQ(keys.number_of(version("a", 5)), 4u);
  ASSERT_TRUE(keys.remove("a", SteadyTime(1s)));
  keys.remove("other", SteadyTime(1s) + OwnKeys::kKeepGone + 1s);
  EXPECT_EQ(keys.number_of(TupleGone{EventKind::kDeleted, "a", 5}), 5u) << "it waited for a slow kernel";
  ASSERT_TRUE(keys.add("a"));
  EXPECT_EQ(keys.number_of(version("a", 1)), 6u);
}

TEST(PeisOwnKeys, ALaterRemovalKeepsTheNumberAsLong) {
  OwnKeys keys;
  ASSERT_TRUE(keys.add("a"));
  EXPECT_EQ(keys.number_of(version("a", 1)), 0u);
  ASSERT_TRUE(keys.remove("a", SteadyTime(1s)));
  ASSERT_TRUE(keys.add("a"));
  EXPECT_EQ(keys.number_of(version("a", 2)), 1u);
  ASSERT_TRUE(keys.remove("a", SteadyTime(1s) + OwnKeys::kKeepGone));
  keys.remove("other", SteadyTime(1s) + OwnKeys::kKeepGone + 1s);
  EXPECT_EQ(keys.number_of(version("a", 2)), 1u) << "an equal version";
}

TEST(PeisPatterns, EachMatchFindsTheKeysBelowAndTheKeyItself) {
  const std::map<std::string, int, std::less<>> keys{{"a", 0}, {"a.b", 0}, {"a.b.c", 0}, {"ab", 0}, {"b.b", 0}};
  const auto found = [&](std::string_view pattern) {
    std::vector<std::string> all;
    each_match(keys, pattern, [&](auto at) { all.push_back(at->first); });
    return all;
  };
  EXPECT_THAT(found("A.**"), ElementsAre("a", "a.b", "a.b.c"));
  EXPECT_THAT(found("a.*"), ElementsAre("a.b"));
  EXPECT_THAT(found("*.b"), ElementsAre("a.b", "b.b"));
  EXPECT_THAT(found("**"), ElementsAre("a", "a.b", "a.b.c", "ab", "b.b"));
  EXPECT_THAT(found("A.b.C"), ElementsAre("a.b.c"));
  EXPECT_THAT(found("a.c"), ElementsAre());
}

TEST(PeisOwnKeys, AreListedUpToALimit) {
  OwnKeys keys;
  EXPECT_EQ(keys.list({}, 100), "()");
  for (const auto* key : {"b", "A", "c"}) ASSERT_TRUE(keys.add(key));
  EXPECT_FALSE(keys.add("B"));
  EXPECT_EQ(keys.list({}, 100), "(A b c)");
  EXPECT_EQ(keys.list({}, 6), "(A b)");
  EXPECT_EQ(keys.list("first", 100), "(first A b c)");
  EXPECT_EQ(*keys.spelling("a"), "A");
  EXPECT_EQ(keys.spelling("d"), nullptr);
}

}  // namespace
}  // namespace rubicon::tuples::peis
