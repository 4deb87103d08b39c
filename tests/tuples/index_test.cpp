#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>

#include "tuples/component.h"
#include "tuples/part_trie.h"
#include "tuples/store.h"

namespace rubicon::tuples {
namespace {

TEST(PartNames, AreForgottenWithTheirLastUse) {
  PartNames names;
  const auto before = names.size();
  const auto part = names.acquire("kitchen");
  EXPECT_EQ(names.acquire("kitchen"), part);
  names.release(part);
  EXPECT_EQ(names.find("kitchen"), part);
  names.release(part);
  EXPECT_EQ(names.find("kitchen"), kNoPart);
  EXPECT_EQ(names.size(), before);
}

TEST(ChildTable, AgreesWithAMapAtRandom) {
  ChildTable table;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> plain;
  std::mt19937 dice(7);
  std::uniform_int_distribution<std::uint32_t> small(0, 39);
  for (std::uint32_t i = 0; i < 100'000; ++i) {
    const std::uint32_t node = small(dice), part = small(dice);
    const auto found = plain.find({node, part});
    ASSERT_EQ(table.find(node, part), found == plain.end() ? ChildTable::kNone : found->second);
    if (found == plain.end()) {
      table.add(node, part, i);
      plain[{node, part}] = i;
    } else {
      table.remove(node, part);
      plain.erase(found);
    }
  }
}

TEST(KeyTable, AgreesWithAMapAtRandom) {
  TuplePool pool;
  KeyTable table(pool);
  std::map<std::pair<std::uint32_t, std::string>, std::uint32_t> plain;
  std::mt19937 dice(5);
  std::uniform_int_distribution<std::uint32_t> owners(1, 3), numbers(0, 499);
  for (int i = 0; i < 100'000; ++i) {
    const auto owner = owners(dice);
    const auto key = "device-" + std::to_string(numbers(dice)) + ".value";
    const auto found = plain.find({owner, key});
    ASSERT_EQ(table.find(OwnerId(owner), key), found == plain.end() ? kNone : found->second);
    if (found == plain.end()) {
      const auto index = plain[{owner, key}] = pool.take(OwnerId(owner), key);
      table.add(index);
    } else {
      table.remove(found->second);
      pool.end(found->second, EventKind::kDeleted);
      plain.erase(found);
    }
  }
}

/// Keys and patterns over few words, so that they meet often; some nodes get many children.
struct Words {
  std::string key(bool wild) {
    std::string text;
    const auto count = 1 + roll(4);
    for (std::size_t i = 0; i < count; ++i) {
      text += i ? "." : "";
      text += wild && roll(3) == 0 ? "*" : "w" + std::to_string(roll(i == 1 ? 20 : 3));
    }
    if (wild && roll(4) == 0) text += ".**";
    return text;
  }
  std::size_t roll(std::size_t sides) { return std::uniform_int_distribution<std::size_t>(0, sides - 1)(dice); }
  std::mt19937 dice{11};
};

TEST(PartTrie, FindsMatchesAndWalksAsPlainPatternsDo) {
  PartNames names;
  PartTrie keys(names), patterns(names);
  Words words;
  std::map<std::string, std::uint32_t> key_nodes;
  std::map<std::string, std::uint32_t> pattern_nodes;
  const auto toggle = [](PartTrie& trie, auto& nodes, const std::string& text, std::uint32_t payload) {
    const auto found = nodes.find(text);
    if (found != nodes.end()) {
      trie.clear(found->second);
      nodes.erase(found);
      return;
    }
    nodes[text] = trie.add(OwnerId(1), text);
    trie.set_payload(nodes[text], payload);
  };
  for (std::uint32_t i = 0; i < 5000; ++i) {
    toggle(keys, key_nodes, words.key(false), i);
    toggle(patterns, pattern_nodes, words.key(true), i);
    if (i % 10 != 0) continue;
    const auto wanted = pattern("1:" + words.key(true));
    std::size_t expected = 0, met = 0, budget = 1'000'000;
    for (const auto& [key, node] : key_nodes) expected += wanted.matches(OwnerId(1), key);
    PatternWalk walk(keys, wanted);
    while (walk.next(budget)) ++met;
    ASSERT_EQ(met, expected) << to_string(wanted);
    const auto concrete = words.key(false);
    std::vector<std::uint32_t> payloads;
    const auto node = keys.add(OwnerId(1), concrete);
    patterns.matching(keys.path(node), payloads);
    if (!key_nodes.contains(concrete)) keys.clear(node);
    const auto matching = std::count_if(pattern_nodes.begin(), pattern_nodes.end(), [&](const auto& entry) {
      return Pattern{std::nullopt, entry.first}.matches(OwnerId(1), concrete);
    });
    ASSERT_EQ(payloads.size(), static_cast<std::size_t>(matching)) << concrete;
  }
  while (!key_nodes.empty()) toggle(keys, key_nodes, std::string(key_nodes.begin()->first), 0);
  while (!pattern_nodes.empty()) toggle(patterns, pattern_nodes, std::string(pattern_nodes.begin()->first), 0);
  EXPECT_EQ(names.size(), PartNames().size());
}

TEST(PatternWalk, SurvivesChangesBetweenItsSteps) {
  PartNames names;
  PartTrie trie(names);
  Words words;
  for (int round = 0; round < 200; ++round) {
    std::map<std::string, std::uint32_t> nodes;
    std::map<std::uint32_t, std::string> untouched;
    for (std::uint32_t i = 0; i < 60; ++i) {
      const auto key = words.key(false);
      if (nodes.contains(key)) continue;
      nodes[key] = trie.add(OwnerId(1), key);
      trie.set_payload(nodes[key], i);
      untouched[i] = key;
    }
    const auto wanted = pattern("*:" + words.key(true));
    PatternWalk walk(trie, wanted);
    std::set<std::uint32_t> met;
    while (!walk.done()) {
      std::size_t budget = 1 + words.roll(3);
      const auto payload = walk.next(budget);
      ASSERT_TRUE(!payload || met.insert(*payload).second);
      if (words.roll(2) == 0 || nodes.empty()) continue;
      const auto gone = std::next(nodes.begin(), static_cast<std::ptrdiff_t>(words.roll(nodes.size())));
      untouched.erase(trie.payload(gone->second));
      trie.clear(gone->second);
      nodes.erase(gone);
    }
    for (const auto& [payload, key] : untouched) {
      ASSERT_EQ(met.contains(payload), wanted.matches(OwnerId(1), key)) << key << " by " << to_string(wanted);
    }
    for (const auto& [key, node] : nodes) trie.clear(node);
  }
}

TEST(SubscriberSets, EqualSetsShareANumberAndUnusedOnesGo) {
  SubscriberSets sets;
  std::vector<SubscriptionPtr> members;
  for (std::uint64_t i = 1; i <= 1000; ++i) {
    members.push_back(std::make_shared<Subscription>());
    members.back()->number = i;
  }
  const auto ab = sets.with(sets.with(0, members[0]), members[1]);
  EXPECT_EQ(sets.with(sets.with(0, members[1]), members[0]), ab);
  EXPECT_EQ(sets.with(ab, members[0]), ab);
  EXPECT_EQ(sets.without(sets.without(ab, members[1]), members[0]), 0u);
  sets.use(ab);
  std::uint32_t all = 0;
  for (const auto& member : members) {
    all = sets.with(all, member);
    sets.use(all);
    sets.collect();
    sets.release(all);
  }
  sets.collect();
  EXPECT_LT(sets.size(), 200u);
  EXPECT_EQ(sets[ab].members.size(), 2u);
  EXPECT_EQ(sets.with(sets.with(0, members[0]), members[1]), ab);
}

}  // namespace
}  // namespace rubicon::tuples
