#include "base/scheduler.h"

#include <gtest/gtest.h>

#include <chrono>
#include <optional>

#include "base/virtual_scheduler.h"

namespace rubicon::base {
namespace {

using namespace std::chrono_literals;

TEST(PacedCall, CallsAtOnceAndThenOncePerPause) {
  VirtualScheduler scheduler;
  int calls = 0;
  PacedCall call(scheduler, 250ms, [&] { ++calls; });
  call.request();
  call.request();
  EXPECT_EQ(calls, 0);
  scheduler.run_ready();
  EXPECT_EQ(calls, 1);
  call.request();
  scheduler.run_for(249ms);
  EXPECT_EQ(calls, 1);
  scheduler.run_for(1ms);
  EXPECT_EQ(calls, 2);
  scheduler.run_for(1s);
  EXPECT_EQ(calls, 2);
  call.request();
  scheduler.run_ready();
  EXPECT_EQ(calls, 3);
}

TEST(PacedCall, WithoutARequestStartsThePauseToo) {
  VirtualScheduler scheduler;
  int calls = 0;
  PacedCall call(scheduler, 250ms, [&] { ++calls; });
  call.request();
  call.call_now();
  EXPECT_EQ(calls, 1);
  call.request();
  scheduler.run_for(249ms);
  EXPECT_EQ(calls, 1);
  scheduler.run_for(1ms);
  EXPECT_EQ(calls, 2);
}

TEST(PacedCall, MayBeRequestedInItsCallAndDestroyedBeforeIt) {
  VirtualScheduler scheduler;
  int calls = 0;
  std::optional<PacedCall> call;
  call.emplace(scheduler, 1s, [&] {
    if (++calls < 3) call->request();
  });
  call->request();
  scheduler.run_for(1500ms);
  EXPECT_EQ(calls, 2);
  call.reset();
  scheduler.run_for(5s);
  EXPECT_EQ(calls, 2);
}

}  // namespace
}  // namespace rubicon::base
