#include "networks/knx/line/line_fixture.h"

namespace rubicon::networks::knx::line {
namespace {

using TunnelOfAHost = LineFixture;

/// The server does not know the new address, so nothing would come back for 100 s.
TEST_F(TunnelOfAHost, ThatLostItsAddressEndsAtTheNextDatagram) {
  std::uint16_t telegram = 0;
  for (const auto nat : {TunnelOptions::Nat::kOff, TunnelOptions::Nat::kOn}) {
    options.nat = nat;
    connect();
    failures.clear();
    net.gone_interfaces.insert("10.0.0.2");
    send(++telegram);
    time.run_for(0s);
    ASSERT_EQ(failures.size(), 1U) << telegram;
    net.gone_interfaces.clear();
    time.run_for(2s);
    EXPECT_EQ(phase(), LineState::Phase::kUp);
  }
}

}  // namespace
}  // namespace rubicon::networks::knx::line
