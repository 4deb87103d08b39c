#include "transport/worker.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "transport/asio_scheduler.h"

namespace rubicon::transport {
namespace {

TEST(Worker, RunsJobsInTheirOrderOnAThreadOfItsOwn) {
  Loop loop;
  const auto worker = start_worker("test");
  std::vector<int> order;
  std::thread::id thread;
  for (int i = 0; i < 100; ++i) {
    worker->run([&, i] {
      order.push_back(i);
      thread = std::this_thread::get_id();
      if (i == 99) loop.scheduler().post([&] { loop.stop(); });
    });
  }
  loop.run();
  ASSERT_EQ(order.size(), 100U);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(order[static_cast<std::size_t>(i)], i);
  EXPECT_NE(thread, std::this_thread::get_id());
}

TEST(Worker, RunsWhatWaitsBeforeItEnds) {
  std::atomic<int> done = 0;
  {
    const auto worker = start_worker("test");
    for (int i = 0; i < 1000; ++i) worker->run([&] { ++done; });
  }
  EXPECT_EQ(done, 1000);
}

TEST(Worker, AJobMayAppendAnother) {
  std::atomic<int> done = 0;
  {
    const auto worker = start_worker("a name that is longer than the system allows");
    auto* same = worker.get();
    worker->run([&, same] { same->run([&] { ++done; }); });
  }
  EXPECT_EQ(done, 1);
}

}  // namespace
}  // namespace rubicon::transport
