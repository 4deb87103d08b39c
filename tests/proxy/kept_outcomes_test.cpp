#include <gmock/gmock.h>

#include "client/remote_set_tracker.h"
#include "commands.h"
#include "proxy/command.h"

namespace rubicon::proxy {
namespace {

using model::command_outcome_from_json;

/// What the status of the flap says of a request of component 70001.
class Outcomes : public Commands {
 protected:
  std::string of(std::uint64_t request) const {
    const auto found = command_outcome_from_json(text(kFlapPoint + ".status"), kTool, request);
    return found ? found->state : "";
  }
  static constexpr OwnerId kTool{70001};
};

TEST_F(Outcomes, OfACommandIsShownBesideTheNextOne) {
  begin();
  set(kFlapCommand, "open");
  report("7", actuator(kFlap), true);
  EXPECT_EQ(command_state(kFlapPoint), "confirmed");
  EXPECT_FALSE(json(kFlapPoint + ".status").contains("ended")) << "it is the last one";
  set(kFlapCommand, "shut");
  EXPECT_EQ(command_state(kFlapPoint), "sent");
  EXPECT_EQ(of(1), "confirmed");
  EXPECT_EQ(of(2), "") << "it has not ended";
  set(kFlapCommand, "open");
  EXPECT_EQ(of(1), "confirmed");
  EXPECT_EQ(of(2), "superseded");
}

TEST_F(Outcomes, AreForgottenAfterAWhileAndNotPublishedForThat) {
  begin();
  set(kFlapCommand, "open");
  set(kFlapCommand, "shut");
  EXPECT_EQ(of(1), "superseded");
  const auto before = text(kFlapPoint + ".status");
  time.run_for(KeptOutcomes::kKept + 1s);
  report("7", actuator(kFlap), false);
  EXPECT_FALSE(json(kFlapPoint + ".status").contains("ended"));
}

TEST_F(Outcomes, AreBoundedForAPoint) {
  begin();
  constexpr int kMore = 20;
  const auto most = static_cast<int>(KeptOutcomes::kMaxPerPoint);
  for (int i = 0; i <= most + kMore; ++i) set(kFlapCommand, i % 2 == 0 ? "open" : "shut");
  EXPECT_EQ(json(kFlapPoint + ".status")["ended"].size(), KeptOutcomes::kMaxPerPoint);
  EXPECT_EQ(of(kMore), "");
  EXPECT_EQ(of(kMore + 1), "superseded");
  EXPECT_EQ(of(static_cast<std::uint64_t>(most + kMore)), "superseded");
}

/// What 8 programs see that command one lamp: each of its requests ends once, whatever the others do.
TEST_F(Outcomes, OfManyCommandersReachEachOfThem) {
  begin();
  std::vector<std::unique_ptr<tuples::Link>> links;
  std::vector<std::unique_ptr<TupleSpace>> spaces;
  std::vector<std::unique_ptr<client::RemoteSetTracker>> trackers;
  std::map<std::string, int> ended;
  for (std::uint32_t i = 0; i < 8; ++i) {
    links.push_back(std::move(*ecology.join(OwnerId(80'000 + i))));
    spaces.push_back(std::make_unique<TupleSpace>(OwnerId(80'000 + i), time, *links.back()));
  }
  time.run_ready();
  constexpr int kRounds = 50;
  for (int round = 0; round < kRounds; ++round) {
    for (auto& space_of : spaces)
      trackers.push_back(std::make_unique<client::RemoteSetTracker>(
          time, *space_of, kIsland, kFlapCommand, round % 2 == 0 ? "open" : "shut",
          [&](const client::Outcome& outcome) { ++ended[outcome.state]; }, 5s, 15s));
    time.run_for(5ms);
    report("7", actuator(kFlap), round % 2 == 0);
  }
  time.run_for(1s);
  EXPECT_EQ(ended["confirmed"] + ended["superseded"], 8 * kRounds);
  EXPECT_EQ(ended["confirmed"], kRounds);
  EXPECT_EQ(ended.size(), 2U) << "nothing timed out";
}

}  // namespace
}  // namespace rubicon::proxy
