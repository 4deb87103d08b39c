#include "transport/transports.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <thread>

#include "base/virtual_scheduler.h"
#include "support/memory/memory_transports.h"
#include "transport/asio_scheduler.h"
#include "transport/local_transports.h"

namespace rubicon::transport {
namespace {

TEST(Worker, RunsJobsInTheirOrderOnAThreadOfItsOwn) {
  Loop loop;
  const auto worker = start_worker("test").value();
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
    const auto worker = start_worker("test").value();
    for (int i = 0; i < 1000; ++i) worker->run([&] { ++done; });
  }
  EXPECT_EQ(done, 1000);
}

TEST(Worker, AJobMayAppendAnother) {
  std::atomic<int> done = 0;
  {
    const auto worker = start_worker("a name that is longer than the system allows").value();
    auto* same = worker.get();
    worker->run([&, same] { same->run([&] { ++done; }); });
  }
  EXPECT_EQ(done, 1);
}

// The sanitizers need memory of their own for each thread.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST(Worker, OfTheTransportsRunsApartAndInMemoryInTurns) {
  Loop loop;
  LocalTransports local(loop);
  std::thread::id thread;
  {
    const auto worker = local.start_worker("test").value();
    worker->run([&] { thread = std::this_thread::get_id(); });
  }
  EXPECT_NE(thread, std::thread::id());
  EXPECT_NE(thread, std::this_thread::get_id());

  VirtualScheduler time;
  MemoryNet net(time);
  MemoryTransports memory;
  EXPECT_EQ(memory.start_worker("test").error().code, ErrorCode::kUnsupported);
  memory.join(net);
  const auto worker = memory.start_worker("test").value();
  bool ran = false;
  worker->run([&] { ran = true; });
  EXPECT_FALSE(ran);
  time.run_for(Duration::zero());
  EXPECT_TRUE(ran);
}

TEST(Worker, AThreadThatTheSystemRefusesIsAnError) {
  const auto child = ::fork();
  if (child == 0) {
    const rlimit none{1 << 20, 1 << 20};
    ::setrlimit(RLIMIT_AS, &none);
    std::vector<std::unique_ptr<Worker>> workers;
    workers.reserve(200);  // the first ones use the memory of threads of the parent
    while (workers.size() < 200) {
      auto worker = start_worker("test");
      if (!worker) ::_exit(worker.error().code == ErrorCode::kIo ? 0 : 2);
      workers.push_back(std::move(*worker));
    }
    ::_exit(3);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
}
#endif

}  // namespace
}  // namespace rubicon::transport
