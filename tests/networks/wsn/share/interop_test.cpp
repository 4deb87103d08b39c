#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <deque>
#include <numeric>

#include "networks/wsn/share/forwarder.h"
#include "support/process.h"
#include "transport/asio_scheduler.h"
#include "transport/local_transports.h"

namespace rubicon::networks::wsn::share {
namespace {

using namespace std::chrono_literals;

/// A sink that has room for some packets at a time only, and answers as tests/networks/wsn/share/forwarder_client.py
/// says.
class EchoingSink {
 public:
  EchoingSink(Scheduler& scheduler, transport::Transports& transports)
      : scheduler_(scheduler), forwarder_(options(), scheduler, transports, calls()) {}

  Forwarder& forwarder() { return forwarder_; }
  const std::vector<int>& numbers_of(std::uint8_t client) { return numbers_[client]; }
  std::uint64_t refused() const { return refused_; }
  const std::vector<std::string>& strange() const { return strange_; }

 private:
  static constexpr std::size_t kRoom = 20;

  static ForwarderOptions options() {
    ForwarderOptions options;
    options.listen.port = 0;
    options.greeting_timeout = 2s;
    return options;
  }
  ForwarderCallbacks calls() {
    ForwarderCallbacks calls;
    calls.packet = [this](ByteView packet) {
      if (waiting_.size() >= kRoom) return ++refused_, false;
      waiting_.emplace_back(packet.begin(), packet.end());
      if (waiting_.size() == 1) work_later();
      return true;
    };
    return calls;
  }
  void work_later() {
    timer_ = scheduler_.after(1ms, [this] {
      for (const auto& packet : std::exchange(waiting_, {})) work(packet);
      forwarder_.resume();
    });
  }
  void work(const Bytes& packet) {
    const auto type = packet[7];
    if (type == 0x70 && packet.size() == 9) {
      ++here_;
    } else if (type == 0x71 && packet.size() == 9) {
      for (int i = 0; i < packet[8]; ++i) beacon();
    } else if (type == 0x72 && packet.size() >= 11) {
      numbers_[packet[8]].push_back(packet[9] * 256 + packet[10]);
    } else {
      strange_.push_back(base::to_hex(packet));
    }
  }
  void beacon() {
    base::ByteWriter writer;
    writer.u8(0).u16_be(0xffff).u16_be(0).u8(114).u8(0).u8(0x73).u32_be(++beacons_);
    const auto counters = forwarder_.counters();
    writer.u8(here_);
    for (const auto* name :
         {"dropped-slow-clients", "dropped-silent", "dropped-strangers", "dropped-config", "dropped-bad-packets"})
      writer.u8(static_cast<std::uint8_t>(counters.at(name)));
    auto packet = writer.take();
    packet.resize(122);
    forwarder_.broadcast(packet);
  }

  Scheduler& scheduler_;
  std::deque<Bytes> waiting_;
  std::map<std::uint8_t, std::vector<int>> numbers_;
  std::vector<std::string> strange_;
  std::uint64_t refused_ = 0;
  std::uint32_t beacons_ = 0;
  std::uint8_t here_ = 0;
  Timer timer_;
  Forwarder forwarder_;
};

/// The program has ended; its exit code is still to be had.
bool has_ended(pid_t pid) {
  siginfo_t info{};
  return ::waitid(P_PID, static_cast<id_t>(pid), &info, WEXITED | WNOHANG | WNOWAIT) == 0 && info.si_pid == pid;
}

/// Runs the loop until the program has ended; false if that takes too long.
bool run_beside(transport::Loop& loop, pid_t pid) {
  const auto end = loop.scheduler().now() + 120s;
  std::function<void()> look;
  Timer timer;
  look = [&] {
    if (has_ended(pid) || loop.scheduler().now() > end) return loop.stop();
    timer = loop.scheduler().after(5ms, look);
  };
  look();
  loop.run();
  return has_ended(pid);
}

TEST(ForwarderInterop, IndependentClientsInAnotherLanguageAreServedAtOnce) {
  transport::Loop loop;
  transport::LocalTransports local(loop);
  EchoingSink sink(loop.scheduler(), local);
  ASSERT_TRUE(sink.forwarder().open());
  const auto at = sink.forwarder().local();
  support::Process client({"python3", RUBICON_SOURCE_DIR "/tests/networks/wsn/share/forwarder_client.py", at.address,
                           std::to_string(at.port), "2"});
  ASSERT_TRUE(run_beside(loop, client.pid())) << "it did not end";
  EXPECT_EQ(client.exit_code(), 0) << client.errors();
  std::vector<int> all(600);
  std::iota(all.begin(), all.end(), 0);
  EXPECT_EQ(sink.numbers_of(1), all) << "every packet once and in order, though there was no room for them at times";
  EXPECT_EQ(sink.numbers_of(2), all);
  EXPECT_THAT(sink.numbers_of(9), testing::ElementsAre(0)) << "what came before the length of 0";
  EXPECT_THAT(sink.strange(), testing::IsEmpty());
  EXPECT_GT(sink.refused(), 10u);
}

}  // namespace
}  // namespace rubicon::networks::wsn::share
