#include "base/text.h"

#include <gtest/gtest.h>

namespace rubicon::base {
namespace {

TEST(TrimmedText, HasNoBlanksAtItsEnds) {
  EXPECT_EQ(trimmed(" \t a b\r\n\f"), "a b");
  EXPECT_EQ(trimmed(" \n"), "");
  EXPECT_EQ(trimmed(""), "");
}

TEST(NumbersInText, AreTheWholeTextAndInRange) {
  EXPECT_EQ(parse_number<int>("-12"), -12);
  EXPECT_EQ(parse_number<double>("1.5e3"), 1500.0);
  EXPECT_EQ(parse_number<std::uint8_t>("255"), 255);
  for (const auto* text : {"", " 1", "1 ", "+1", "1x", "256", "-1", "1.0"})
    EXPECT_EQ(parse_number<std::uint8_t>(text), std::nullopt) << text;
}

TEST(NumbersInText, MayBeHexadecimal) {
  EXPECT_EQ(parse_hex_number<std::uint16_t>("fF0a"), 0xff0a);
  for (const auto* text : {"", "0x1", "10000", "g"})
    EXPECT_EQ(parse_hex_number<std::uint16_t>(text), std::nullopt) << text;
}

TEST(RelativePaths, StartAtTheDirectoryOfTheirFile) {
  EXPECT_EQ(resolve_path("/etc/rubicon", "flat.csv"), "/etc/rubicon/flat.csv");
  EXPECT_EQ(resolve_path("/etc/rubicon/", "/var/flat.csv"), "/var/flat.csv");
  EXPECT_EQ(resolve_path("", "flat.csv"), "flat.csv");
  // If /etc/rubicon is a symbolic link, this is not /etc/flat.csv.
  EXPECT_EQ(resolve_path("/etc/rubicon", "../flat.csv"), "/etc/rubicon/../flat.csv");
}

TEST(HostsWithPorts, AreANameOrAnAddressAndAPort) {
  EXPECT_EQ(parse_host_port("flat.local:9002"), (HostPort{"flat.local", 9002}));
  EXPECT_EQ(parse_host_port("[::1]:65535"), (HostPort{"::1", 65535}));
  EXPECT_EQ(parse_host_port(":80"), (HostPort{"", 80}));
  for (const auto* text : {"", "host", "host:", "host:0", "host:65536", "host:x", "::1:9002", "[::1]", "[host]:1",
                           "[:1", "]:1", "a b:1", "host:+1"})
    EXPECT_EQ(parse_host_port(text), std::nullopt) << text;
}

TEST(HostsWithPorts, MayHaveADefaultPort) {
  EXPECT_EQ(parse_host_port("host", 7), (HostPort{"host", 7}));
  EXPECT_EQ(parse_host_port("host:8", 7), (HostPort{"host", 8}));
  EXPECT_EQ(parse_host_port("[::1]", 7), (HostPort{"::1", 7}));
  for (const auto* text : {"", "::1", "host:", "host:0"}) EXPECT_EQ(parse_host_port(text, 7), std::nullopt) << text;
}

}  // namespace
}  // namespace rubicon::base
