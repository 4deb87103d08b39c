#include "island/island_state.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/folder.h"

namespace rubicon::island {
namespace {

using network::Keep;
using testing::HasSubstr;

TEST(NetworkMemory, KeepsValuesInTheStateFile) {
  support::Folder folder;
  const auto store = state::StateStore::open(folder / "s", IslandId{1}).value();
  NetworkMemory memory(store.get());
  ASSERT_TRUE(memory.remember("knx", "sequence.1.1.200", Bytes{1, 2, 3}, Keep::kNow));
  EXPECT_EQ(*memory.remembered("knx", "sequence.1.1.200"), (Bytes{1, 2, 3}));
  EXPECT_EQ(*memory.remembered("knx-2", "sequence.1.1.200"), std::nullopt);
  EXPECT_EQ(*store->remembered("knx", "sequence.1.1.200"), (Bytes{1, 2, 3}));
}

TEST(NetworkMemory, RefusesNamesAndValuesBeyondItsLimits) {
  support::Folder folder;
  const auto store = state::StateStore::open(folder / "s", IslandId{1}).value();
  NetworkMemory memory(store.get());
  for (const auto& name : {std::string(), std::string(65, 'a'), std::string("Sequence"), std::string("a b")})
    EXPECT_EQ(memory.remember("knx", name, Bytes{1}, Keep::kNow).error().code, ErrorCode::kOutOfRange) << name;
  EXPECT_TRUE(memory.remember("knx", std::string(64, 'a'), Bytes(4096), Keep::kSoon));
  const auto large = memory.remember("knx", "a", Bytes(4097), Keep::kNow);
  ASSERT_FALSE(large);
  EXPECT_EQ(large.error().code, ErrorCode::kOutOfRange);
  EXPECT_THAT(large.error().text, HasSubstr("4097 bytes, at most 4096"));
}

TEST(NetworkMemory, WithoutAStateFileRemembersNothing) {
  NetworkMemory memory(nullptr);
  const auto kept = memory.remember("knx", "sequence", Bytes{1}, Keep::kNow);
  ASSERT_FALSE(kept);
  EXPECT_EQ(kept.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(kept.error().text, HasSubstr("state: {file: ...}"));
  EXPECT_EQ(memory.remembered("knx", "sequence").error().code, ErrorCode::kUnsupported);
}

}  // namespace
}  // namespace rubicon::island
