#include "tuples/carry/forwarded_sets.h"

#include <gtest/gtest.h>

#include "tuples/carry/carrying.h"

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

class NoEvents final : public StandInEvents {
  void on_changes(const StandInPort&, OwnerId, std::span<const Change>) override {}
  void on_subscribe(StandInPort&, OwnerId, const SubscriptionSpec&) override {}
  void on_unsubscribe(const StandInPort&, OwnerId, std::uint32_t) override {}
  void on_remote_set(StandInPort&, const RemoteSet&) override {}
  bool on_reply(const StandInPort&, OwnerId, const Reply&) override { return true; }
  void on_met(const StandInPort&, OwnerId, PeerEvent) override {}
};

TEST_F(Carrying, TheNumbersOfRemoteSetsRiseForEachOwnerAlsoForOneThatIsForgotten) {
  const auto home = join(dds, 7);
  NoEvents events;
  StandInPort reader({OwnerId(8), 1, "there"}, 1, 0, std::move(*dds.join(OwnerId(8))), events);
  reader.begin(1);
  time.run_ready();
  reader.requested(OwnerId(7), 3);
  constexpr std::uint32_t kFirst = 100, kLast = kFirst + StandInPort::kMaxOwners - 2;
  for (std::uint32_t id = kFirst; id <= kLast; ++id) reader.requested(OwnerId(id), id);
  EXPECT_EQ(reader.last_request(OwnerId(kFirst)), kFirst) << "it went, and may come back";
  EXPECT_EQ(reader.last_request(OwnerId(9)), 0U);
  reader.requested(OwnerId(kLast + 1), 5);
  EXPECT_EQ(reader.last_request(OwnerId(kLast + 1)), 5U);
  EXPECT_EQ(reader.last_request(OwnerId(7)), 3U) << "it is there";
  EXPECT_EQ(reader.last_request(OwnerId(kFirst)), kLast) << "above what each forgotten one knows";
}

}  // namespace
}  // namespace rubicon::tuples::carry
