#include <gtest/gtest.h>

#include <csignal>

#include "transport/asio_scheduler.h"

namespace rubicon::transport {
namespace {

TEST(Signals, EachOneIsACall) {
  Loop loop;
  int calls = 0;
  const Signals signals(loop, {SIGHUP}, [&] {
    if (++calls == 3) return loop.stop();
    std::raise(SIGHUP);  // while it is handled
  });
  std::raise(SIGHUP);
  loop.run();
  EXPECT_EQ(calls, 3);
}

TEST(Signals, ACallMayEndThem) {
  Loop loop;
  int calls = 0;
  std::unique_ptr<Signals> signals;
  signals = std::make_unique<Signals>(loop, std::vector{SIGHUP}, [&] {
    ++calls;
    signals.reset();
    loop.stop();
  });
  std::raise(SIGHUP);
  loop.run();
  EXPECT_EQ(calls, 1);
  EXPECT_FALSE(signals);
}

}  // namespace
}  // namespace rubicon::transport
