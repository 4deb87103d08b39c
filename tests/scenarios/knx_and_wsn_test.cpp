#include "networks/knx/wire/address.h"
#include "scenarios/motes.h"
#include "support/knx_server.h"

namespace rubicon::scenarios {
namespace {

/// The ecology of D1.4, figure 3.1: one proxy with a network of motes and a KNX line, on which an output register of 8
/// bits regulates a dimmer.
class KnxAndWsn : public Motes {
 protected:
  static constexpr const char* kOutput = "knx.1_4_6.actuator.unsigned8BitOutput-1";

  void SetUp() override {
    begin_world(2, em1000());
    const std::string knx =
        "knx: {type: knx, host: 10.0.0.8, telegrams-per-second: 0, groups: {1/4/6: {dpt: 5.*, kind: actuator, state: "
        "1/4/7, device: 1.4.6}, 1/4/5: {dpt: 9.001, device: 1.4.5}}}";
    start(1, network("wsn-1", 1) + "\n  " + knx);
    scheduler.run_for(5s);
  }
  static std::uint16_t group(std::string_view text) { return number(networks::knx::wire::parse_group(text).value()); }

  support::KnxServer bus{scheduler, net, {.at = {"10.0.0.8", 3671}}};
};

TEST_F(KnxAndWsn, InOneProxyAreReadAndCommandedAlike) {
  const auto light = want(1, "wsn-1.2.sensor.light-1");
  bus.inject(0x1105, group("1/4/5"), 0x80, {0x0c, 0x33});
  bus.inject(0x1106, group("1/4/7"), 0x80, {12});
  scheduler.run_for(10s);
  EXPECT_EQ(seen(1, "proxy.devices"), R"(["knx.1_4_5","knx.1_4_6","wsn-1.2","wsn-1.3"])") << "all were heard";
  EXPECT_EQ(seen_json(1, "proxy.wsn-1.2.sensor.light-1.status")["quality"], "good");
  EXPECT_EQ(seen(1, "proxy.knx.1_4_5.sensor.temperature-1.value"), "21.5");
}

TEST_F(KnxAndWsn, TheOutputRegisterSetsTheDimmerAndItsReportConfirms) {
  bus.on_heard = [this](const auto& frame) {
    if (frame.destination == group("1/4/6")) bus.inject(0x1106, group("1/4/7"), 0x80, {frame.tpdu.at(2)});
  };
  for (const auto* level : {"0", "12", "255"}) {
    EXPECT_EQ(command(1, kOutput, level).verdict, tuples::Verdict::kApplied) << level;
    scheduler.run_for(2s);
    EXPECT_EQ(seen(1, std::string("proxy.") + kOutput + ".value"), level);
    EXPECT_EQ(command_state(1, kOutput), "confirmed");
  }
  EXPECT_EQ(command(1, kOutput, "256").verdict, tuples::Verdict::kRefused);
  EXPECT_EQ(command(1, kOutput, "0.5").verdict, tuples::Verdict::kRefused);
}

}  // namespace
}  // namespace rubicon::scenarios
