#include "tuples/peis/discovery.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tuples/peis/peis_world.h"

namespace rubicon::tuples::peis {
namespace {

using namespace std::chrono_literals;
using ::testing::Contains;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

/// A dialer whose tries all fail, and what it tries.
class PeisDialer : public ::testing::Test {
 protected:
  void start(bool loopback_only, std::vector<base::HostPort> configured = {}) {
    Dialer::Callbacks calls;
    calls.is_linked = calls.is_routable = [](OwnerId) { return false; };
    calls.record = [this](OwnerId) { return &record; };
    calls.claim = [](OwnerId) { return nullptr; };
    calls.dial = [this](const Target&, const transport::Endpoint& to, std::uint32_t) {
      dialed.insert(transport::to_string(to));
      return false;
    };
    calls.unresolved = [this](const Target&, const Error& error) { errors.push_back(error.text); };
    dialer = std::make_unique<Dialer>(world.time, world.machine,
                                      Dialer::Own{OwnerId(200), "hostx", std::move(configured), 1, loopback_only},
                                      std::move(calls));
  }

  PeisWorld world;
  HostRecord record;
  std::unique_ptr<Dialer> dialer;
  std::set<std::string> dialed;
  std::vector<std::string> errors;
};

TEST_F(PeisDialer, WithLoAloneNoAnnouncedAddressOfAnotherHostIsTried) {
  record.host_name = "elsewhere";
  record.addresses = {{"eth0", false, AddressType::kTcp4, {10, 9, 9, 1}, 8000}};
  start(false);
  dialer->meet(OwnerId(101), true, true);
  world.run(10s);
  EXPECT_THAT(dialed, UnorderedElementsAre("10.9.9.1:8000"));
  dialed.clear();
  start(true);
  dialer->meet(OwnerId(101), true, true);
  world.run(10s);
  EXPECT_THAT(dialed, IsEmpty());
}

TEST_F(PeisDialer, WithLoAloneAConfiguredNameOfAnotherHostIsATrouble) {
  world.net.name("robot.lan", {"10.9.9.1"});
  start(true, {{"robot.lan", 8000}, {"10.9.9.2", 8000}});
  world.run(10s);
  EXPECT_THAT(dialed, IsEmpty());
  EXPECT_THAT(errors,
              AllOf(Contains(HasSubstr("lo reaches no other host")), Each(HasSubstr("expected another interface"))));
}

TEST_F(PeisDialer, WithLoAloneANameIsTriedAtItsLoopbackAddress) {
  world.net.name("here.lan", {"10.9.9.1", "127.0.1.1"});
  start(true, {{"here.lan", 8000}});
  world.run(10s);
  EXPECT_THAT(dialed, UnorderedElementsAre("127.0.1.1:8000"));
  EXPECT_THAT(errors, IsEmpty());
}

}  // namespace
}  // namespace rubicon::tuples::peis
