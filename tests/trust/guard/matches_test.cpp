#include "trust/guard/matches.h"

#include <gtest/gtest.h>

#include <thread>

namespace rubicon::trust::guard {
namespace {

constexpr Handle kReader = 10, kOtherReader = 11, kBuiltin = 12, kMallory = 20, kDesk = 21;
constexpr Handle kPermissionsOfMallory = 30, kPermissionsOfDesk = 31;
constexpr Masks kFrames{0x8000000f, 0x80000001};

/// A process with two readers of frames, and two remote participants.
class MatchesTest : public testing::Test {
 protected:
  MatchesTest() {
    local(kReader, "rubicon_frames", "*.00000007");
    local(kOtherReader, "rubicon_frames", "*.01c00001");
    matches_.local_endpoint(kBuiltin, true, {});
    matches_.participant(kPermissionsOfMallory, kMallory, 1);
    matches_.participant(kPermissionsOfDesk, kDesk, 2);
  }
  void local(Handle handle, const std::string& topic, const std::string& partition) {
    matches_.prepare(topic, {partition});
    matches_.local_endpoint(handle, false, kFrames);
  }
  Approval yes(const void* writer, Handle permissions = kPermissionsOfMallory) const {
    return {Kind::Writer, permissions, writer, kFrames, "rubicon_frames", {"01b00001.00000007"}};
  }
  bool admits(Handle reader, Handle remote) { return !matches_.refusal(Kind::Writer, reader, remote); }

  Matches matches_;
  const int first_ = 0, second_ = 0;  ///< their addresses stand for remote writers
};

TEST_F(MatchesTest, AWriterThatNobodyAskedAboutIsRefused) {
  EXPECT_FALSE(admits(kReader, kMallory));
}

TEST_F(MatchesTest, AnApprovedWriterIsAdmittedOnce) {
  Matches::approve(yes(&first_));
  EXPECT_TRUE(admits(kReader, kMallory));
  EXPECT_FALSE(admits(kReader, kMallory));
}

TEST_F(MatchesTest, OwnEndpointsOfDdsNeedNoApproval) {
  EXPECT_TRUE(admits(kBuiltin, kMallory));
}

TEST_F(MatchesTest, AnApprovalOfOneParticipantDoesNotServeAnother) {
  Matches::approve(yes(&first_, kPermissionsOfDesk));
  EXPECT_FALSE(admits(kReader, kMallory));
}

TEST_F(MatchesTest, AnApprovalOfAParticipantThatWentServesNobody) {
  Matches::approve(yes(&first_));
  matches_.participant_gone(kMallory);
  EXPECT_FALSE(admits(kReader, kMallory));
}

TEST_F(MatchesTest, AnotherQuestionTakesTheApprovalBack) {
  Matches::approve(yes(&first_));
  Matches::ask();
  EXPECT_FALSE(admits(kReader, kMallory));
}

TEST_F(MatchesTest, AnApprovalOfAReaderDoesNotServeAWriter) {
  auto reader = yes(&first_);
  reader.kind = Kind::Reader;
  Matches::approve(reader);
  EXPECT_FALSE(admits(kReader, kMallory));
}

TEST_F(MatchesTest, AnApprovalServesOnItsThreadOnly) {
  std::thread([this] { Matches::approve(yes(&first_)); }).join();
  EXPECT_FALSE(admits(kReader, kMallory));
}

// Cyclone asks about a writer that it does not register then, and next comes one that it does not ask about.

TEST_F(MatchesTest, TheApprovalOfAWriterThatIsMatchedAlreadyDoesNotServeAnother) {
  Matches::approve(yes(&first_));
  ASSERT_TRUE(admits(kReader, kMallory));
  matches_.matched(40, kReader);
  Matches::approve(yes(&first_));
  EXPECT_FALSE(admits(kReader, kMallory));
  matches_.endpoint_gone(40);
  Matches::approve(yes(&first_));
  EXPECT_TRUE(admits(kReader, kMallory));
}

TEST_F(MatchesTest, TwoWritersInOnePartitionAreBothAdmitted) {
  Matches::approve(yes(&first_));
  ASSERT_TRUE(admits(kReader, kMallory));
  matches_.matched(40, kReader);
  Matches::approve(yes(&second_));
  EXPECT_TRUE(admits(kReader, kMallory));
}

TEST_F(MatchesTest, TheApprovalOfAWriterWithOtherAttributesDoesNotServeAnother) {
  auto odd = yes(&first_);
  odd.masks.attributes ^= 1U << 5U;
  Matches::approve(odd);
  EXPECT_FALSE(admits(kReader, kMallory));
}

TEST_F(MatchesTest, TheApprovalForAPartitionDoesNotServeInAnother) {
  Matches::approve(yes(&first_));
  EXPECT_FALSE(admits(kOtherReader, kMallory));
}

TEST_F(MatchesTest, TheApprovalForATopicDoesNotServeInAnother) {
  auto presence = yes(&first_);
  presence.topic = "rubicon_presence";
  Matches::approve(presence);
  EXPECT_FALSE(admits(kReader, kMallory));
}

TEST(Partitions, MatchAsInDds) {
  EXPECT_TRUE(partitions_match({}, {""}));
  EXPECT_TRUE(partitions_match({"a"}, {"b", "a"}));
  EXPECT_TRUE(partitions_match({"7.8"}, {"*.8"}));
  EXPECT_TRUE(partitions_match({"*"}, {"7.8"}));
  EXPECT_FALSE(partitions_match({"7.8"}, {"*.9"}));
  EXPECT_FALSE(partitions_match({"7.*"}, {"*.8"}));
  EXPECT_FALSE(partitions_match({"a"}, {}));
}

}  // namespace
}  // namespace rubicon::trust::guard
