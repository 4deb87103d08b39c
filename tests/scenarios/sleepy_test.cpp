#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "base/virtual_scheduler.h"
#include "config/yaml.h"
#include "island/island.h"
#include "island/network_types.h"
#include "support/collecting_log.h"
#include "support/memory/memory_transports.h"
#include "tuples/memory/memory_ecology.h"

namespace rubicon::scenarios {
namespace {

using namespace std::chrono_literals;

constexpr const char* kConfiguration = R"(island: {id: 1, name: home}
networks:
  dummy-1: {type: dummy, silence: 5s, simulate: {sleepy: {keepalive: 35s, actuators: {lock-1: {}}}}}
)";

/// A simulated lock whose device speaks each 35 s and counts as unreachable after 5 s.
class Sleepy : public testing::Test {
 protected:
  void SetUp() override {
    base::ConfigErrors errors;
    auto config = island::read_island_config(config::parse_yaml(kConfiguration, "home.yaml").value(),
                                             island::network_types(), errors);
    auto made = island::Island::make(std::move(config), scheduler_, transports_, log_, ecology_, errors);
    ASSERT_TRUE(made.has_value()) << errors.text();
    island_ = std::move(*made);
    island_->start();
    scheduler_.run_for(15s);
    ASSERT_EQ(json("proxy.dummy-1.sleepy.status")["status"], "unreachable");
  }
  std::string value(const std::string& key) const {
    const auto tuple = island_->space().get(OwnerId(1), key);
    return tuple ? std::string(tuple->value) : "(none)";
  }
  nlohmann::json json(const std::string& key) const { return nlohmann::json::parse(value(key), nullptr, false); }
  nlohmann::json command() const { return json(kLock + ".status")["command"]; }
  void set(const std::string& text, Duration time_to_live = {}) {
    user_.set_remote(OwnerId(1), kLock + ".command", text, time_to_live, nullptr);
    scheduler_.run_for(1ms);
  }

  const std::string kLock = "proxy.dummy-1.sleepy.actuator.lock-1";
  VirtualScheduler scheduler_;
  transport::MemoryTransports transports_;
  support::CollectingLog log_;
  tuples::MemoryEcology ecology_{scheduler_};
  std::unique_ptr<tuples::Link> link_ = ecology_.join(OwnerId(70001)).value();
  TupleSpace user_{OwnerId(70001), scheduler_, *link_};
  std::unique_ptr<island::Island> island_;
};

TEST_F(Sleepy, IsNotLockedAfterTheCommandExpired) {
  const auto before = value(kLock + ".value");
  ASSERT_NE(before, "locked");
  set("locked");
  EXPECT_EQ(command()["state"], "queued");
  scheduler_.run_for(5s);
  EXPECT_EQ(command()["state"], "expired");
  EXPECT_TRUE(log_.contains(kLock + " = 'locked' by component 70001, id 70001: expired after 5.00 s: not sent within"));
  scheduler_.run_for(2min);
  EXPECT_EQ(value(kLock + ".value"), before);
  EXPECT_EQ(command()["state"], "expired");
}

TEST_F(Sleepy, IsLockedWhenItWakesIfTheUserGaveItTheTime) {
  set("locked", 1min);
  scheduler_.run_for(40s);
  EXPECT_EQ(value(kLock + ".value"), "locked");
  EXPECT_EQ(command()["state"], "confirmed");
}

}  // namespace
}  // namespace rubicon::scenarios
