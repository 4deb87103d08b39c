#include "support/process.h"

#include <gtest/gtest.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <memory>

namespace rubicon::support {
namespace {

/// A pipe whose writing end programs that a test starts inherit: it ends with the last of them.
class Thread {
 public:
  Thread() { EXPECT_EQ(::pipe(ends_), 0); }
  ~Thread() {
    ::close(ends_[0]);
    let_go();
  }
  Thread(const Thread&) = delete;
  Thread& operator=(const Thread&) = delete;
  void let_go() {
    if (ends_[1] >= 0) ::close(ends_[1]);
    ends_[1] = -1;
  }
  /// Within a minute.
  bool ends() const {
    pollfd wanted{ends_[0], POLLIN, 0};
    return ::poll(&wanted, 1, 60'000) == 1 && (wanted.revents & POLLHUP) != 0;
  }

 private:
  int ends_[2] = {-1, -1};
};

TEST(ProcessUnderTest, EndsWithAllItStarted) {
  Thread thread;
  {
    Process shell({"sh", "-c", "sleep 1000 & sleep 1000 & echo started; wait"});
    thread.let_go();
    ASSERT_TRUE(shell.line());
  }
  EXPECT_TRUE(thread.ends());
}

TEST(ProcessUnderTest, LeavesNothingBehindWhenItEndedItself) {
  Thread thread;
  {
    Process shell({"sh", "-c", "sleep 1000 </dev/null >/dev/null 2>&1 & exit 3"});
    thread.let_go();
    EXPECT_EQ(shell.exit_code(), 3);
  }
  EXPECT_TRUE(thread.ends());
}

/// zigbee.md, section 12, pitfall 20: Zigbee2MQTT under load ignores the signal to terminate for seconds.
TEST(ProcessUnderTest, Pitfall20_EndsAlsoIfItIgnoresTheSignalToTerminate) {
  Thread thread;
  {
    Process shell({"sh", "-c", "trap '' TERM; echo started; while :; do sleep 1000; done"});
    thread.let_go();
    ASSERT_TRUE(shell.line());
    ASSERT_EQ(::kill(shell.pid(), SIGTERM), 0);
  }
  EXPECT_TRUE(thread.ends());
}

TEST(ProcessUnderTest, EndsWithATestThatIsKilled) {
  Thread thread;
  const auto test = ::fork();
  if (test == 0) {
    const auto kept = std::make_unique<Process>(std::vector<std::string>{"sleep", "1000"});
    ::kill(::getpid(), SIGKILL);
  }
  thread.let_go();
  ASSERT_EQ(::waitpid(test, nullptr, 0), test);
  EXPECT_TRUE(thread.ends());
}

TEST(ProcessUnderTest, TellsItsCodeAndItsSignal) {
  EXPECT_EQ(run_to_end({"sh", "-c", "exit 7"}).code, 7);
  EXPECT_EQ(run_to_end({"sh", "-c", "kill -TERM $$"}).code, 128 + SIGTERM);
  EXPECT_EQ(run_to_end({"/nonexistent"}).code, 127);
}

}  // namespace
}  // namespace rubicon::support
