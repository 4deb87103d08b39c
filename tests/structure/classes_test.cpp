#include <gtest/gtest.h>

#include <map>
#include <regex>
#include <sstream>

#include "structure/classes.h"
#include "structure/tree.h"

namespace rubicon::structure {
namespace {

constexpr std::size_t kMaxMembers = 60;

/// Classes that have more, and how many: none may grow.
const std::map<std::string, std::size_t> kLarge{
    {"apps/rubicon-proxy/daemon.cpp Session", 64},
    {"apps/simulators/knx/server.h Server", 91},
    {"apps/simulators/motes/sink_firmware.h SinkFirmware", 70},
    {"src/networks/knx/line/tunnel_line.h TunnelLine", 81},
    {"src/networks/log/log_network_impl.h LogNetwork", 64},
    {"src/networks/wsn/wsn_network.cpp WsnNetwork", 61},
    {"src/networks/zigbee/device_table.h DeviceTable", 81},
    {"src/tuples/carry/carrier.h Carrier", 77},
    {"src/tuples/host/host_ecology.h HostEcology", 68},
    {"src/tuples/mqtt/mqtt_ecology.h MqttEcology", 96},
    {"src/tuples/mqtt/mqtt_link.h MqttLink", 68},
    {"src/tuples/peis/connection.h Connection", 66},
    {"src/tuples/peis/kernel_session.h KernelSession", 80},
    {"src/tuples/space_impl.h TupleSpace::Impl", 104},
    {"src/web/api/socket.h Socket", 75},
};

/// A reader holds no more in mind: a class of more has parts of its state that are classes.
TEST(Classes, HaveAtMost60Members) {
  std::map<std::string, std::size_t> found;
  std::size_t all = 0;
  for (const auto& file : product_sources()) {
    for (const auto& one : classes_of(file.text)) {
      ++all;
      if (one.members.size() > kMaxMembers) found[file.path + " " + one.name] = one.members.size();
    }
  }
  EXPECT_GE(all, 1500U);
  for (const auto& [name, members] : found) {
    const auto large = kLarge.find(name);
    EXPECT_LE(members, large == kLarge.end() ? kMaxMembers : large->second) << name;
  }
  for (const auto& [name, members] : kLarge) EXPECT_TRUE(found.contains(name)) << name << " need not be listed";
}

TEST(Classes, MembersAreFunctionsAndVariables) {
  const auto all = classes_of(R"(
    class Outer::Inner final : private Base<int, bool> {
     public:
      Inner(int a, std::map<int, bool> b = {}) : a_(a), b_{b}, c_{1} { use({}); }
      template <class Call>
      void each(Call call) { call([] { return 1; }); }  // void not_a_member();
      bool operator==(const Inner&) const = default;
      enum class Kind { kOne, kTwo };
      struct Part { int x = 0, y = 0; };
      using Parts = std::vector<Part>;
     private:
      friend class Other;
      std::function<void(int, bool)> call_;
      static constexpr std::size_t kMaxParts = 10'000, kMaxOther = 2;
      int a_ = 0;
      Timer b_{scheduler_, [this] { go(); }}, c_;
    };)");
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0].name, "Outer::Inner");
  EXPECT_EQ(all[0].members.size(), 9U);
  EXPECT_EQ(all[1].name, "Part");
  EXPECT_EQ(all[1].members.size(), 2U);
}

}  // namespace
}  // namespace rubicon::structure
