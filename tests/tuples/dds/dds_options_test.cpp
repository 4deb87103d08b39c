#include "tuples/dds/dds_options.h"

#include <gmock/gmock.h>

#include <chrono>

#include "base/virtual_scheduler.h"
#include "transport/host_names.h"

namespace rubicon::tuples::dds {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

DdsOptions on(std::vector<std::string> interfaces, std::vector<std::string> peers = {}) {
  DdsOptions options;
  options.interfaces = std::move(interfaces);
  options.peers = std::move(peers);
  return options;
}

TEST(DdsOptions, LoopbackHasATagThatNoOtherHostKnows) {
  DdsOptions options;
  EXPECT_THAT(domain_xml(options), HasSubstr("<Tag>@" + transport::host_id("tag") + "</Tag>"));
  options.tag = "lab";
  EXPECT_THAT(domain_xml(options), HasSubstr("<Tag>lab@" + transport::host_id("tag") + "</Tag>"));
  options.interfaces = {"eth0"};
  EXPECT_THAT(domain_xml(options), HasSubstr("<Tag>lab</Tag>"));
  EXPECT_NE(transport::host_id("tag"), transport::host_id("host")) << "the host is told to everybody, the tag is not";
  EXPECT_EQ(transport::host_id("host"), transport::host_id("host"));
  EXPECT_EQ(transport::host_id("host").size(), 16U);
}

/// Cyclone collects the fragments of samples of anybody.
TEST(DdsOptions, SamplesAreBounded) {
  EXPECT_THAT(domain_xml({}), HasSubstr("<MaxSampleSize>4 MiB</MaxSampleSize>"));
}

TEST(DdsOptions, WhereTheAddressMayGoADomainEndsWithoutADatagramToIt) {
  EXPECT_THAT(domain_xml({}), Not(HasSubstr("MultipleReceiveThreads"))) << "that of loopback stays";
  EXPECT_THAT(domain_xml(on({"eth0"})), HasSubstr("<MultipleReceiveThreads>false</MultipleReceiveThreads>"));
}

TEST(DdsOptions, OnLoopbackALongLeaseLeavesTimeBetweenHeartbeats) {
  const auto interval = [](DdsOptions options, base::Duration lease) {
    options.lease = lease;
    const auto xml = domain_xml(options);
    const auto from = xml.find("<HeartbeatInterval>") + 19;
    return xml.substr(from, xml.find('<', from) - from);
  };
  EXPECT_EQ(interval({}, 500ms), "100 ms") << "the default of Cyclone DDS";
  EXPECT_EQ(interval({}, 2s), "100 ms");
  EXPECT_EQ(interval({}, 10s), "500 ms");
  EXPECT_EQ(interval({}, 60s), "1000 ms");
  EXPECT_EQ(interval(on({"eth0"}), 60s), "100 ms") << "a LAN loses packets";
}

TEST(DdsOptions, MulticastStopsWhereHostsAreNamed) {
  EXPECT_THAT(domain_xml({}), HasSubstr("<AllowMulticast>spdp</AllowMulticast>"));
  EXPECT_THAT(domain_xml(on({"eth0"})), HasSubstr("<AllowMulticast>true</AllowMulticast>"));
  EXPECT_THAT(domain_xml(on({"eth0"}, {"10.0.0.7"})), HasSubstr("<AllowMulticast>false</AllowMulticast>"));
  EXPECT_THAT(domain_xml(on({"eth0"}, {"unknown.name"})), HasSubstr("<AllowMulticast>false</AllowMulticast>"));
}

TEST(DdsOptions, OfAHostWithoutAPortTheFirstProcessesAreLookedFor) {
  auto options = on({"eth0"}, {"10.0.0.7", "10.0.0.8:99", "unknown.name"});
  options.domain = 2;
  const auto xml = domain_xml(options);
  EXPECT_THAT(xml, HasSubstr("\"10.0.0.7:7910\""));
  EXPECT_THAT(xml, HasSubstr("\"10.0.0.7:7924\""));
  EXPECT_THAT(xml, Not(HasSubstr("\"10.0.0.7:7926\"")));
  EXPECT_THAT(xml, HasSubstr("\"10.0.0.8:99\""));
  EXPECT_THAT(xml, Not(HasSubstr("unknown.name")));
  EXPECT_EQ(port_of(0, 0), 7410U);
  EXPECT_EQ(domain_of_port(7410), 0U);
  EXPECT_EQ(domain_of_port(65'148), kMaxDomain);
  for (const auto port : {7400U, 7408U, 7411U, 65'150U}) EXPECT_EQ(domain_of_port(port), std::nullopt) << port;
  EXPECT_EQ(port_of(kMaxDomain, kMaxProcessesPerHost - 1), 65'148U) << "there are no ports behind 65535";
}

TEST(DdsOptions, WhatUsersWriteStaysText) {
  auto options = on({"a\"/><b"});
  options.tag = "<x>&";
  const auto xml = domain_xml(options);
  EXPECT_THAT(xml, HasSubstr("<Tag>&lt;x&gt;&amp;</Tag>"));
  EXPECT_THAT(xml, HasSubstr("name=\"a&quot;/&gt;&lt;b\""));
}

TEST(DdsHost, SaysWhatIsWrongWithAnInterface) {
  const std::vector<transport::Interface> there{{"lo", "127.0.0.1", true, false},
                                                {"eth0", "10.0.0.1", true, true},
                                                {"wg0", "10.1.0.1", true, false},
                                                {"bare", "", true, true}};
  EXPECT_TRUE(check_interfaces({}, there));
  EXPECT_TRUE(check_interfaces(on({"eth0"}), there));
  EXPECT_TRUE(check_interfaces(on({"wg0"}, {"10.1.0.2"}), there));
  EXPECT_THAT(check_interfaces(on({"eth0", "wg0"}), there).error().text, HasSubstr("'wg0' has no multicast"));
  EXPECT_THAT(check_interfaces(on({"bare"}), there).error().text, HasSubstr("'bare' has no IPv4 address"));
  EXPECT_THAT(check_interfaces(on({"eth1"}), there).error().text,
              HasSubstr("no interface 'eth1' on this host; there are: lo, eth0, wg0, bare"));
}

TEST(DdsHost, ResolvesNamesAndKeepsPorts) {
  VirtualScheduler time;
  std::vector<std::string> unknown;
  EXPECT_THAT(
      with_addresses({"localhost", "localhost:7", "10.0.0.7", "10.0.0.7:8"}, time, std::chrono::seconds(1), unknown),
      ElementsAre("127.0.0.1", "127.0.0.1:7", "10.0.0.7", "10.0.0.7:8"));
  EXPECT_TRUE(unknown.empty());
  EXPECT_THAT(with_addresses({"localhost", "10.0.0.7"}, time, Duration(0), unknown),
              ElementsAre("localhost", "10.0.0.7"));
  EXPECT_THAT(unknown, ElementsAre("localhost")) << "no time was left to ask";
}

}  // namespace
}  // namespace rubicon::tuples::dds
