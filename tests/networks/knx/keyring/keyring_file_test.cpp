#include "networks/knx/keyring/keyring_file.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rubicon::networks::knx::keyring {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using ::testing::SizeIs;

constexpr std::string_view kBlock64 = "AAECAwQFBgcICQoLDA0ODw==";

std::string document(const std::string& body) {
  return fmt::format(
      "<Keyring Project=\"P\" CreatedBy=\"ETS\" Created=\"2026\" Signature=\"{}\" "
      "xmlns=\"http://knx.org/xml/keyring/1\">\n{}\n</Keyring>",
      kBlock64, body);
}

std::string error_of(const std::string& text) {
  const auto file = parse_keyring(text);
  EXPECT_FALSE(file) << text;
  return file ? std::string() : file.error().text;
}

TEST(KeyringFile, FormsOfEtsAreRead) {
  const auto file = parse_keyring(document(R"(<Interface IndividualAddress="1.1.40" Type="USB">
<Group Address="65535" Senders="" /><Group Address="1/2/7" Senders=" 1.1.1  1.1.2 "/></Interface>
<Interface IndividualAddress="1.1.13" Type="Tunneling" Host="1.1.0" Authentication="AAECAwQFBgcICQoLDA0ODw=="/>
<Devices><Device IndividualAddress="1.1.30" ToolKey="AAECAwQFBgcICQoLDA0ODw==" SequenceNumber="281474976710000"/>
<Device IndividualAddress="1.1.31"/></Devices><Future Thing="1"><Deep/></Future>)"));
  ASSERT_TRUE(file) << file.error().text;
  ASSERT_THAT(file->interfaces, SizeIs(2));
  EXPECT_EQ(number(file->interfaces[0].host), 0) << "USB";
  ASSERT_THAT(file->interfaces[0].groups, SizeIs(2));
  EXPECT_EQ(number(file->interfaces[0].groups[0].address), 65535);
  EXPECT_THAT(file->interfaces[0].groups[0].senders, SizeIs(0));
  EXPECT_THAT(file->interfaces[0].groups[1].senders, SizeIs(2));
  EXPECT_FALSE(file->interfaces[1].user);
  EXPECT_TRUE(file->interfaces[1].password.empty());
  EXPECT_EQ(file->interfaces[1].authentication.size(), 16U);
  EXPECT_EQ(file->devices.at(0).sequence, 281474976710000U);
  EXPECT_FALSE(file->devices.at(1).sequence);
  EXPECT_FALSE(file->backbone);
}

TEST(KeyringFile, ElementsHaveAMeaningAtTheirPlaceOnly) {
  const auto file = parse_keyring(document(R"(<Intreface><Group Address="1" Senders="x"/></Intreface>
<Future><Interface Type="Tunneling" UserID="x"><Group Address="1" Senders="1.1.1"/></Interface><Backbone/></Future>
<Interface Type="USB"><Future><Group Address="1"/></Future></Interface>)"));
  ASSERT_TRUE(file) << file.error().text;
  ASSERT_THAT(file->interfaces, SizeIs(1));
  EXPECT_THAT(file->interfaces[0].groups, SizeIs(0));
}

TEST(KeyringFile, LatencyHasADefault) {
  const auto with = [](const std::string& latency) {
    return parse_keyring(
        document("<Backbone MulticastAddress=\"224.0.23.12\" " + latency + " Key=\"AAECAwQFBgcICQoLDA0ODw==\"/>"));
  };
  EXPECT_EQ(with("")->backbone->latency, 2s);
  EXPECT_EQ(with("Latency=\"1500\"")->backbone->latency, 1500ms);
  EXPECT_FALSE(with("Latency=\"0\""));
  EXPECT_FALSE(with("Latency=\"8001\""));
}

/// ETS 6 (6.2.2 and later) writes the address of the backbone into each project.
TEST(KeyringFile, TheBackboneOfEts6MayHaveNoKey) {
  const auto file = parse_keyring(document(R"(<Backbone MulticastAddress="224.0.23.12" />
<Devices><Device IndividualAddress="1.1.30" ToolKey="AAECAwQFBgcICQoLDA0ODw==" SerialNumber="00FA12345678"
 FDSK="AAECAwQFBgcICQoLDA0ODw==" SequenceNumber="17" /></Devices>)"));
  ASSERT_TRUE(file) << file.error().text;
  ASSERT_TRUE(file->backbone);
  EXPECT_EQ(file->backbone->multicast, "224.0.23.12");
  EXPECT_TRUE(file->backbone->key.empty());
  EXPECT_THAT(file->devices, SizeIs(1));
  EXPECT_THAT(error_of(document("<Backbone MulticastAddress=\"224.0.23.12\" Key=\"AAEC\"/>")),
              HasSubstr("Key has 3 bytes, expected 16"));
}

/// By hand from the rule of knx.md, section 12.
TEST(KeyringFile, TheSignatureCoversNamesAndSortedAttributesOfAllElements) {
  const auto file = parse_keyring(
      "<Keyring xmlns=\"n\" Signature=\"AAECAwQFBgcICQoLDA0ODw==\" Created=\"c\"><x b=\"2\" "
      "a=\"&lt;\"/></Keyring>");
  ASSERT_TRUE(file) << file.error().text;
  EXPECT_EQ(base::as_text(file->signed_bytes), std::string_view("\1\7Keyring\7Created\1c\1\1x\1a\1<\1b\0012\2\2", 32));
}

TEST(KeyringFile, OfALongValueTheLengthIsSignedModulo256) {
  const auto file = parse_keyring(document("<x a=\"" + std::string(300, 'y') + "\"/>"));
  ASSERT_TRUE(file);
  const auto text = std::string(base::as_text(file->signed_bytes));
  EXPECT_THAT(text, HasSubstr(std::string("\1a") + char(300 - 256) + "yyy"));
}

TEST(KeyringFile, WhatIsWrongIsNamedWithItsLineAndNoSecret) {
  EXPECT_THAT(error_of("<GroupAddress-Export/>"),
              HasSubstr("line 1: root element 'GroupAddress-Export', expected Keyring"));
  EXPECT_THAT(error_of("<Keyring Signature=\"AAECAwQFBgcICQoLDA0ODw==\"/>"), HasSubstr("no attribute Created"));
  EXPECT_THAT(error_of("<Keyring Created=\"c\"/>"), HasSubstr("Signature has 0 bytes, expected 16"));
  EXPECT_THAT(error_of(document("<Interface IndividualAddress=\"1.1\"/>")), HasSubstr("line 2: IndividualAddress"));
  EXPECT_THAT(error_of(document("<Interface UserID=\"128\"/>")), HasSubstr("UserID is '128', expected 1 to 127"));
  EXPECT_THAT(error_of(document("<Interface Password=\"AAEC\"/>")), HasSubstr("Password has 3 bytes"));
  EXPECT_THAT(error_of(document("<Interface Password=\"secret!\"/>")), HasSubstr("Password is not base 64"));
  EXPECT_THAT(error_of(document("<GroupAddresses><Group Address=\"1/2/7\"/></GroupAddresses>")),
              HasSubstr("Key has 0 bytes, expected 16"));
  EXPECT_THAT(
      error_of(document("<GroupAddresses><Group Address=\"0\" Key=\"AAECAwQFBgcICQoLDA0ODw==\"/></GroupAddresses>")),
      HasSubstr("Address"));
  EXPECT_THAT(error_of(document("<Interface><Group Address=\"1\" Senders=\"1.1.1,1.1.2\"/></Interface>")),
              HasSubstr("Senders"));
  EXPECT_THAT(error_of(document("<Devices><Device SequenceNumber=\"281474976710656\"/></Devices>")),
              HasSubstr("expected a number of 48 bits"));
  EXPECT_THAT(error_of("<!DOCTYPE a [<!ENTITY b \"b\">]><Keyring/>"), HasSubstr("DOCTYPE not allowed"));
  EXPECT_THAT(error_of("<Keyring Created=\"c\" Signature=\"AAECAwQFBgcICQoLDA0ODw==\"><a>"), HasSubstr("ends inside"));
  EXPECT_THAT(error_of(""), HasSubstr("ends inside"));
}

}  // namespace
}  // namespace rubicon::networks::knx::keyring
