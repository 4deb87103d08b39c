#include "tuples/dds/dds_threads.h"

#include <dds/ddsrt/log.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/virtual_scheduler.h"
#include "support/collecting_log.h"

namespace rubicon::tuples::dds {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// The lines of the log of what Cyclone says.
struct CycloneLogTest : testing::Test {
  std::unique_ptr<CycloneLog> make() {
    return std::make_unique<CycloneLog>(
        time, [this](std::function<void()> call) { time.post(std::move(call)); }, sink);
  }
  static void says(std::uint32_t category, const std::string& text) {
    ::dds_log(category, __FILE__, __LINE__, "test", "%s\n", text.c_str());
  }
  static void warns(const std::string& text) { says(DDS_LC_WARNING, text); }
  std::vector<std::string> said() {
    time.run_ready();
    return std::exchange(sink.lines, {});
  }

  VirtualScheduler time;
  support::CollectingLog sink;
};

TEST_F(CycloneLogTest, SaysWhatAMessageMeansBeforeTheWordsOfCyclone) {
  const auto log = make();
  warns("malformed packet received from vendor 1.16 state parse:info_dst");
  EXPECT_THAT(said(), ElementsAre(HasSubstr("a packet that is not valid was dropped (Cyclone DDS: malformed packet "
                                            "received from vendor 1.16 state parse:info_dst)")));
  warns("udp_conn_write to udp/192.0.2.1:7400 failed with retcode -1.");
  EXPECT_THAT(said(), ElementsAre(HasSubstr("a packet could not be sent (Cyclone DDS: udp_conn_write to")));
  says(DDS_LC_ERROR, "something that nobody knows");
  EXPECT_THAT(said(), ElementsAre(HasSubstr("Cyclone DDS says: something that nobody knows")));
}

TEST_F(CycloneLogTest, TheOneBeforeGoesOnWhenTheLatestEnds) {
  const auto log = make();
  auto other = make();
  other.reset();
  warns("tcp write failed");
  EXPECT_THAT(said(), ElementsAre(HasSubstr("tcp write failed")));
}

TEST_F(CycloneLogTest, SaysEachKindOnceAMinute) {
  const auto log = make();
  for (int i = 0; i < 3; ++i) warns("malformed packet " + std::to_string(i));
  warns("tcp write failed");
  EXPECT_THAT(said(), ElementsAre(HasSubstr("malformed packet 0"), HasSubstr("tcp write failed")));
  time.run_for(std::chrono::seconds(61));
  warns("malformed packet 3");
  EXPECT_THAT(said(), ElementsAre(HasSubstr("malformed packet 3")));
}

TEST_F(CycloneLogTest, ACaptureTakesTheWordsAlone) {
  const auto log = make();
  {
    const CycloneLog::Capture capture;
    warns("malformed packet");
    says(DDS_LC_ERROR, "out of resources.");
    EXPECT_EQ(capture.text, "malformed packet; out of resources");
  }
  EXPECT_THAT(said(), IsEmpty());
}

}  // namespace
}  // namespace rubicon::tuples::dds
