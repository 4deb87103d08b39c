#include "apps/rubicon-proxy/service_notice.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cstddef>
#include <cstdlib>
#include <optional>

#include "base/virtual_scheduler.h"

namespace rubicon::daemon {
namespace {

using namespace std::chrono_literals;

/// A service manager that listens at an abstract address of this process.
class ServiceNotices : public testing::Test {
 protected:
  void SetUp() override {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    name_.copy(address.sun_path + 1, sizeof address.sun_path - 1, 1);
    const auto length = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + name_.size());
    ASSERT_EQ(::bind(socket_, reinterpret_cast<const sockaddr*>(&address), length), 0);
  }
  void TearDown() override { ::close(socket_); }

  std::optional<std::string> heard() const {
    std::array<char, 4096> buffer;
    const auto count = ::recv(socket_, buffer.data(), buffer.size(), 0);
    if (count < 0) return std::nullopt;
    return std::string(buffer.data(), static_cast<std::size_t>(count));
  }
  int signs_of_life(Duration time) {
    int count = 0;
    for (Duration gone{0}; gone < time; gone += 10ms) {
      time_.run_for(10ms);
      while (const auto notice = heard()) count += *notice == "WATCHDOG=1" ? 1 : 0;
    }
    return count;
  }

  base::VirtualScheduler time_;
  const std::string name_ = "@rubicon-notices-" + std::to_string(::getpid());
  const int socket_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
};

TEST_F(ServiceNotices, SignsOfLifeComeTwiceInTheTimeThatTheManagerWaits) {
  ServiceNotice notice(time_, {name_, 2s});
  EXPECT_EQ(signs_of_life(10s), 0);  // while it starts, another patience holds
  notice.ready("up");
  EXPECT_EQ(heard(), "READY=1\nSTATUS=up");
  EXPECT_EQ(heard(), "WATCHDOG=1");
  EXPECT_EQ(signs_of_life(10s), 10);
  notice.ready("up again");
  EXPECT_EQ(signs_of_life(10s), 10);  // still one stream of them
}

TEST_F(ServiceNotices, AStatusIsOneLine) {
  ServiceNotice notice(time_, {name_, 0s});
  notice.stopping("bad\nREADY=1\ttoo");
  EXPECT_EQ(heard(), "STOPPING=1\nSTATUS=bad READY=1 too");
  time_.run_for(1h);
  EXPECT_EQ(heard(), std::nullopt);  // nobody asked for signs of life
}

TEST_F(ServiceNotices, WhatAManagerThatIsBusyDoesNotTakeComesLaterAndNothingBlocks) {
  ServiceNotice notice(time_, {name_, 1s});
  notice.ready("0");
  time_.run_for(1h);  // its queue is full of signs of life by now
  for (int reload = 1; reload <= 100; ++reload) notice.ready(std::to_string(reload));
  int notices = 0;
  std::string last;
  for (int round = 0; round < 100; ++round) {
    while (const auto heard_now = heard()) {
      if (!heard_now->starts_with("READY=1")) continue;
      last = *heard_now;
      ++notices;
    }
    time_.run_for(50ms);
  }
  EXPECT_EQ(last, "READY=1\nSTATUS=100");
  EXPECT_LT(notices, 100);  // what waits is bounded, the latest is what counts
}

TEST_F(ServiceNotices, NobodyIsToldWhereNobodyAskedOrTheAddressIsUnsound) {
  for (const auto& address : {std::string(), std::string("@"), std::string("vsock:2:1234"), std::string("relative"),
                              "/" + std::string(200, 'x'), std::string("/nowhere/notify")}) {
    ServiceNotice notice(time_, {address, 1s});
    notice.ready("up");
    notice.stopping("down");
    time_.run_for(10s);
  }
  EXPECT_EQ(heard(), std::nullopt);
}

/// Variables of the environment, for the length of a test.
class Variables {
 public:
  void set(const char* name, const std::string& value) {
    ::setenv(name, value.c_str(), 1);
    names_.push_back(name);
  }
  ~Variables() {
    for (const auto* name : names_) ::unsetenv(name);
  }

 private:
  std::vector<const char*> names_;
};

TEST(ServiceSettingsOfTheEnvironment, AreTakenWhenTheyAreForThisProcess) {
  Variables variables;
  variables.set("NOTIFY_SOCKET", "/run/systemd/notify");
  variables.set("WATCHDOG_USEC", "20000000");
  EXPECT_EQ(ServiceSettings::from_environment().socket, "/run/systemd/notify");
  EXPECT_EQ(ServiceSettings::from_environment().watchdog, 20s);
  variables.set("WATCHDOG_PID", std::to_string(::getpid()));
  EXPECT_EQ(ServiceSettings::from_environment().watchdog, 20s);
  variables.set("WATCHDOG_PID", "1");
  EXPECT_EQ(ServiceSettings::from_environment().watchdog, 0s);
}

TEST(ServiceSettingsOfTheEnvironment, NonsenseAsksForNothing) {
  Variables variables;
  for (const auto* text : {"", "x", "-5", "12s", "99999999999999999999999"}) {
    variables.set("WATCHDOG_USEC", text);
    EXPECT_EQ(ServiceSettings::from_environment().watchdog, 0s) << text;
  }
  variables.set("WATCHDOG_USEC", "18446744073709551615");
  EXPECT_LE(ServiceSettings::from_environment().watchdog, 24h);
}

}  // namespace
}  // namespace rubicon::daemon
