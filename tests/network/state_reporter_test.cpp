#include "network/line_reports.h"

#include <gtest/gtest.h>

#include "support/fake_host.h"

namespace rubicon::network {
namespace {

using namespace std::chrono_literals;

class StateReporterTest : public ::testing::Test {
 protected:
  std::size_t reports() const { return host.all<model::State>().size(); }

  support::FakeHost host;
  std::optional<model::State> state = model::State{model::LineState::kUp, {}, {}};
  StateReporter reporter{host, [this] { return state; }};
};

TEST_F(StateReporterTest, ReportsAChangeOfTheLineAtOnce) {
  reporter.line_changed();
  EXPECT_EQ(reports(), 1U);
}

TEST_F(StateReporterTest, ReportsManyChangesOfCountersOnceInASecond) {
  for (int i = 0; i < 1000; ++i) reporter.counters_changed();
  EXPECT_EQ(reports(), 0U);
  host.time.run_for(1s);
  EXPECT_EQ(reports(), 1U);
  host.time.run_for(1min);
  EXPECT_EQ(reports(), 1U);
}

TEST_F(StateReporterTest, AReportOfTheLineHasTheCountersToo) {
  reporter.counters_changed();
  reporter.line_changed();
  host.time.run_for(1min);
  EXPECT_EQ(reports(), 1U);
}

TEST_F(StateReporterTest, DeliversNothingWithoutAState) {
  state.reset();
  reporter.line_changed();
  reporter.counters_changed();
  host.time.run_for(1min);
  EXPECT_EQ(reports(), 0U);
}

}  // namespace
}  // namespace rubicon::network
