#include "tuples/stored_text.h"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

#include "tuples/component.h"
#include "tuples/memory/memory_ecology.h"

namespace rubicon::tuples {
namespace {

const std::string kLong(200, 'x'), kOther(180, 'y');

StoredText text_of(std::string_view text) {
  StoredText made;
  made.assign(text);
  return made;
}

TEST(StoredText, IsWhatWasAssignedOfAnyLength) {
  StoredText text;
  EXPECT_EQ(text.view(), "");
  for (const auto size : std::vector<std::size_t>{1, 14, 15, 16, 17, 200, 100'000, 15, 0, 16, 3}) {
    const std::string wanted(size, static_cast<char>('a' + size % 26));
    text.assign(wanted);
    EXPECT_EQ(text.view(), wanted);
    EXPECT_EQ(text.size(), size);
  }
}

TEST(StoredText, TakesAPartOfItself) {
  auto text = text_of("0123456789" + kLong);
  text.assign(text.view().substr(8, 20));
  EXPECT_EQ(text.view(), "89" + std::string(18, 'x'));
  text.append(text.view());
  EXPECT_EQ(text.view(), "89" + std::string(18, 'x') + "89" + std::string(18, 'x'));
  text.assign(text.view().substr(0, 6));
  text.append(text.view());
  EXPECT_EQ(text.view(), "89xxxx89xxxx");
}

TEST(StoredText, CopiesShareTheirTextUntilOneChanges) {
  auto one = text_of(kLong);
  auto other = one;
  EXPECT_EQ(one.view().data(), other.view().data());
  other.append("!");
  EXPECT_EQ(one.view(), kLong);
  EXPECT_EQ(other.view(), kLong + "!");
  const auto third = one;
  one.assign(kOther);
  EXPECT_EQ(third.view(), kLong);
  EXPECT_EQ(one.view(), kOther);
}

TEST(StoredText, WritesToTheSameMemoryAgain) {
  auto text = text_of(kLong);
  const auto* const before = text.view().data();
  text.assign(kOther);
  EXPECT_EQ(text.view().data(), before);
  text.assign(kLong.substr(0, 20));
  EXPECT_NE(text.view().data(), before) << "a block for ten times as much is kept";
}

TEST(StoredText, OutlivesWhatItWasCopiedOrMovedFrom) {
  std::vector<StoredText> all;
  for (int i = 0; i < 100; ++i) all.push_back(text_of(std::to_string(i) + (i % 2 ? kLong : "")));
  auto copies = all;
  const auto moved = std::move(all.front());
  all.clear();
  EXPECT_EQ(moved.view(), "0");
  for (int i = 0; i < 100; ++i)
    EXPECT_EQ(copies[static_cast<std::size_t>(i)].view(), std::to_string(i) + (i % 2 ? kLong : ""));
  auto& same = copies[1];
  same = copies[1];
  EXPECT_EQ(same.view(), "1" + kLong);
}

/// Against std::string, by any order of its calls.
TEST(StoredText, DoesWhatAStringDoes) {
  std::mt19937 dice(7);
  std::vector<StoredText> texts(4);
  std::vector<std::string> wanted(4);
  for (int step = 0; step < 20'000; ++step) {
    const auto at = dice() % 4, from = dice() % 4;
    const std::string more(dice() % 40, static_cast<char>('a' + dice() % 26));
    switch (dice() % 4) {
      case 0: texts[at].assign(more), wanted[at] = more; break;
      case 1: texts[at].append(more), wanted[at] += more; break;
      case 2: texts[at] = texts[from], wanted[at] = std::string(wanted[from]); break;
      default: texts[at].assign(texts[from].view().substr(0, 30)), wanted[at] = std::string(wanted[from]).substr(0, 30);
    }
    ASSERT_EQ(texts[at].view(), wanted[at]) << step;
    ASSERT_EQ(texts[from].view(), wanted[from]) << step;
  }
}

TEST(SharedTexts, GivesEqualTextsOneBlock) {
  SharedTexts texts;
  StoredText one, other, third;
  texts.assign(one, kLong);
  texts.assign(other, std::string(kLong));
  EXPECT_EQ(one.view().data(), other.view().data());
  for (int i = 0; i < 10'000; ++i) texts.assign(third, kLong + std::to_string(i));
  EXPECT_EQ(third.view(), kLong + "9999");
  EXPECT_EQ(one.view(), kLong);
}

TEST(SharedTexts, TuplesThatAreDeclaredAlikeShareTheirValue) {
  VirtualScheduler scheduler;
  MemoryEcology ecology(scheduler);
  Component island(ecology, scheduler, 1);
  for (const auto* key : {"a.description", "b.description"}) ASSERT_TRUE(island.space.declare(key, kLong));
  const auto value = [&](std::string_view key) { return island.space.get(OwnerId(1), key)->value; };
  EXPECT_EQ(value("a.description").data(), value("b.description").data());
  ASSERT_TRUE(island.space.set("a.description", kOther));
  EXPECT_EQ(value("a.description"), kOther);
  EXPECT_EQ(value("b.description"), kLong);
}

}  // namespace
}  // namespace rubicon::tuples
