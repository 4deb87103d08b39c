#include "base/text.h"

#include <gtest/gtest.h>

namespace rubicon::base {
namespace {

TEST(HostFault, ANameOrAnAddressHasNone) {
  for (const auto* text : {"knx.lan", "192.168.10.5", "::1", "fe80::1", "gateway", "a1.2"})
    EXPECT_EQ(host_fault(text), "") << text;
}

TEST(HostFault, SaysWhatIsWrong) {
  EXPECT_EQ(host_fault(""), "expected a host name or an address");
  for (const auto* text : {"mqtt://localhost", "me@there", "two words"})
    EXPECT_EQ(host_fault(text), "expected a host name or an address") << text;
  for (const auto* text : {"192.168.10.500", "192.168.10", "1.2.3.4.5", "1..2.3", "10", "1.2.3."})
    EXPECT_EQ(host_fault(text), "is no IPv4 address, expected four numbers from 0 to 255, or a name") << text;
  for (const auto* text : {"192.168.10.5:3671", "knx.lan:3671"})
    EXPECT_EQ(host_fault(text), "names a port too, expected that in 'port'") << text;
}

}  // namespace
}  // namespace rubicon::base
