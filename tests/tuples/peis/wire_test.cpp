#include "tuples/peis/wire.h"

#include <gtest/gtest.h>

#include "tuples/peis/rewritten.h"

namespace rubicon::tuples::peis {
namespace {

// The hex texts are those of peis.md, sections 3 and 6.

Bytes hex(std::string_view text) {
  return base::from_hex(text).value();
}
Bytes zeros(std::size_t count) {
  return Bytes(count);
}
Bytes joined(const std::vector<Bytes>& parts) {
  Bytes all;
  for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}
/// A text in a field of this size.
Bytes field(std::string_view text, std::size_t size) {
  Bytes bytes(text.begin(), text.end());
  bytes.resize(size);
  return bytes;
}

const HostRecord kHost{
    OwnerId{101}, 0x3be8db5c, "hostx", "compA@hostx!6011", {{"lo", true, AddressType::kTcp4, {127, 0, 0, 1}, 8000}},
    OwnerId{101}, 0};

const Bytes& announcement_bytes() {
  static const Bytes bytes = joined({hex("000001f4 00000000"), field("default", 64), hex("00000065 3be8db5c"),
                                     field("hostx", 64), field("compA@hostx!6011", 64), hex("01000000 00000000"),
                                     hex("6c6f0000 00000000 01000000 00000000 7f000001 00001f40"), zeros(15 * 24),
                                     zeros(8), hex("00000065 00000000")});
  return bytes;
}

std::string error_of_announcement(std::size_t at, std::string_view replacement) {
  auto bytes = announcement_bytes();
  const auto patch = hex(replacement);
  std::copy(patch.begin(), patch.end(), bytes.begin() + static_cast<std::ptrdiff_t>(at));
  const auto read = read_announcement(bytes);
  return read ? "read" : read.error().text;
}

TEST(PeisWire, AnAnnouncementHasTheBytesOfTheReference) {
  const Announcement announcement{"default", kHost};
  EXPECT_EQ(base::to_hex(write(announcement)), base::to_hex(announcement_bytes()));
  const auto read = read_announcement(announcement_bytes());
  ASSERT_TRUE(read) << read.error().text;
  EXPECT_EQ(*read, announcement);
}

TEST(PeisWire, AnAnnouncementOfAnotherVersionIsUnsupported) {
  auto bytes = announcement_bytes();
  bytes[3] = 0xf5;
  const auto read = read_announcement(bytes);
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error(),
            (Error{ErrorCode::kUnsupported, "announcement of id 101: protocol version 501, expected 500"}));
}

TEST(PeisWire, ErrorsOfAnAnnouncementNameTheFieldAndWhatWasExpected) {
  auto longer = announcement_bytes();
  longer.push_back(0);
  EXPECT_EQ(read_announcement(longer).error().text, "announcement: 617 bytes, expected 616");
  EXPECT_EQ(read_announcement(ByteView(longer).first(615)).error().text, "announcement: 615 bytes, expected 616");
  EXPECT_EQ(error_of_announcement(8, "00"), "announcement: network name at 8: empty");
  EXPECT_EQ(error_of_announcement(8, std::string(128, '7')),
            "announcement: network name at 8: 64 bytes without NUL, expected one");
  EXPECT_EQ(error_of_announcement(72, "ffffffff"), "announcement: host id at 72: ffffffff, expected 0 to 7fffffff");
  EXPECT_EQ(error_of_announcement(72 + 8, std::string(128, '7')),
            "announcement: host name at 80: 64 bytes without NUL, expected one");
  EXPECT_EQ(error_of_announcement(72 + 72, std::string(128, '7')),
            "announcement: full name at 144: 64 bytes without NUL, expected one");
  EXPECT_EQ(error_of_announcement(72 + 136, "11"), "announcement: number of addresses at 208: 17, expected at most 16");
}

TEST(PeisWire, AHostMayHaveSixteenAddressesOfAnyType) {
  auto host = kHost;
  host.addresses.assign(kMaxAddresses, {"wlan0abc", false, AddressType::kBluetooth, {1, 2, 3, 4}, 0xffffffff});
  const auto read = read_host_info(write(HostRecordMessage{host, true}));
  ASSERT_TRUE(read) << read.error().text;
  EXPECT_EQ(read->host, host);
  EXPECT_TRUE(read->cached);
}

TEST(PeisWire, NamesOfAHostAreCutAt63Bytes) {
  auto host = kHost;
  host.host_name = std::string(64, 'h');
  host.full_name = std::string(200, 'f');
  const auto read = read_host_info(write(HostRecordMessage{host, false}));
  ASSERT_TRUE(read) << read.error().text;
  EXPECT_EQ(read->host.host_name, std::string(63, 'h'));
  EXPECT_EQ(read->host.full_name, std::string(63, 'f'));
}

TEST(PeisWire, AConnectMessageHasTheBytesOfTheReference) {
  const ConnectMessage message{OwnerId{102}, kForcedByCluster, "default"};
  const auto bytes = joined({hex("000001f4 00000066 00000004"), field("default", 64)});
  EXPECT_EQ(base::to_hex(write(message)), base::to_hex(bytes));
  EXPECT_EQ(read_connect(bytes).value(), message);
}

TEST(PeisWire, AConnectMessageOfAnotherVersionOrIdIsRefused) {
  auto bytes = write(ConnectMessage{OwnerId{102}, 0, "default"});
  bytes[3] = 0xf5;
  EXPECT_EQ(read_connect(bytes).error(),
            (Error{ErrorCode::kUnsupported, "connect message of id 102: protocol version 501, expected 500"}));
  bytes[3] = 0xf4;
  bytes[4] = 0x80;
  EXPECT_EQ(read_connect(bytes).error().text, "connect message: id at 4: 80000066, expected 0 to 7fffffff");
}

TEST(PeisWire, ARoutingPageHasTheBytesOfTheReference) {
  const RoutingPage page{0, 1, 1, {{OwnerId{101}, 1, 0x3be8db5c, 0, 1}, {OwnerId{102}, 0, 0x091bc4c1, 1, 1}}};
  const auto bytes =
      hex("0000 0001 0002 0065 00000001 00000065 00000001 3be8db5c 00 01 00000066 00000000 091bc4c1 01 01");
  EXPECT_EQ(read_routing_page(bytes).value(), page);
  auto cleared = bytes;
  cleared[7] = 0;  // padding
  EXPECT_EQ(base::to_hex(write(page)), base::to_hex(cleared));
}

TEST(PeisWire, ErrorsOfARoutingPageNameTheFieldAndWhatWasExpected) {
  const auto error = [](std::string_view text) {
    const auto bytes = hex(text);
    const auto page = read_routing_page(bytes);
    return page ? std::string() : page.error().text;
  };
  EXPECT_EQ(error("0000 0001 0000 0000 000000"), "ROUTING: 11 bytes, expected at least 12");
  EXPECT_EQ(error("0000 0001 0047 0000 00000000"), "ROUTING: entries at 4: 71, expected at most 70");
  EXPECT_EQ(error("0000 0001 0001 0000 00000000"), "ROUTING: 12 bytes, expected 26");
  EXPECT_EQ(error("0001 0001 0000 0000 00000000"), "ROUTING: page at 0: 1 of 1, expected less");
  EXPECT_EQ(error("0000 0001 0001 0000 00000001 ffffffff 00000001 3be8db5c 0001"),
            "ROUTING: id of entry 0: ffffffff, expected 0 to 7fffffff");
}

TEST(PeisWire, AFullRoutingPageFitsAPackage) {
  RoutingPage page{2, 3, 7, {}};
  for (std::uint32_t i = 0; i < kMaxRoutesOfPage; ++i) page.entries.push_back({OwnerId{i + 1}, i, ~i, 249, 255});
  EXPECT_LE(write(page).size(), kMaxBody);
  EXPECT_EQ(read_routing_page(write(page)).value(), page);
}

TEST(PeisWire, AcksHaveTheBytesOfTheReference) {
  EXPECT_EQ(read_acks(hex("00000001 66015dc5")).value(), Acks{{0x66015dc5}});
  const auto four = hex("00000004 0e69c923 145606d3 40786574 74df7cfb");
  EXPECT_EQ(read_acks(four).value(), (Acks{{0x0e69c923, 0x145606d3, 0x40786574, 0x74df7cfb}}));
  EXPECT_EQ(base::to_hex(write(read_acks(four).value())), base::to_hex(four));
}

TEST(PeisWire, ErrorsOfAcksNameTheFieldAndWhatWasExpected) {
  const auto error = [](std::string_view text) { return read_acks(hex(text)).error().text; };
  EXPECT_EQ(error("000000"), "ACKS: 3 bytes, expected at least 4");
  EXPECT_EQ(error("00000002 66015dc5"), "ACKS: 8 bytes, expected 12");
  EXPECT_EQ(error("ffffffff 66015dc5"), "ACKS: count at 0: 4294967295, expected at most 255");
  EXPECT_TRUE(read_acks(write(Acks{std::vector<std::uint32_t>(kMaxReadAcks, 1)})));
}

TEST(PeisWire, SmallMessagesHaveTheBytesOfTheReference) {
  EXPECT_EQ(read_dead_host(hex("00000066 00000001")).value(), (DeadHost{OwnerId{102}, DeathReason::kLost}));
  EXPECT_EQ(base::to_hex(write(DeadHost{OwnerId{102}, DeathReason::kLost})), "0000006600000001");
  const TimeSync time{0x6b00e45a, 642173, true};
  EXPECT_EQ(read_time_sync(hex("6b00e45a 0009cc7d 01000000")).value(), time);
  EXPECT_EQ(base::to_hex(write(time)), "6b00e45a0009cc7d01000000");
  EXPECT_EQ(read_query_host(hex("00000066 ffffffff")).value(), (QueryHost{OwnerId{102}, kAnyId}));
  EXPECT_EQ(base::to_hex(write(QueryHost{OwnerId{102}})), "00000066ffffffff");
  const auto trace = joined({hex("00000002 000000c8 00000065"), zeros(52)});
  EXPECT_EQ(read_trace(trace).value(), (Trace{{OwnerId{200}, OwnerId{101}}}));
  EXPECT_EQ(base::to_hex(write(read_trace(trace).value())), base::to_hex(trace));
}

TEST(PeisWire, ErrorsOfSmallMessagesNameTheFieldAndWhatWasExpected) {
  EXPECT_EQ(read_dead_host(hex("00000066")).error().text, "DEAD_HOST: 4 bytes, expected 8");
  EXPECT_EQ(read_dead_host(hex("80000066 00000001")).error().text,
            "DEAD_HOST: id at 0: 80000066, expected 0 to 7fffffff");
  EXPECT_EQ(read_query_host(hex("ffffffff ffffffff")).error().text,
            "QUERY_HOST: asker at 0: ffffffff, expected 0 to 7fffffff");
  EXPECT_EQ(read_query_host(hex("00")).error().text, "QUERY_HOST: 1 bytes, expected 8");
  EXPECT_EQ(read_time_sync(hex("6b00e45a 000f4240 01000000")).error().text,
            "TIMESYNC: microseconds at 4: 1000000, expected at most 999999");
  EXPECT_EQ(read_time_sync({}).error().text, "TIMESYNC: 0 bytes, expected 12");
  EXPECT_EQ(read_trace(joined({hex("00000010"), zeros(60)})).error().text, "TRACE: hops at 0: 16, expected at most 15");
  EXPECT_EQ(read_trace(joined({hex("00000001 ffffffff"), zeros(56)})).error().text,
            "TRACE: id 0: ffffffff, expected 0 to 7fffffff");
}

/// What is read is written as something that reads the same, whatever the length and the bytes.
TEST(PeisWire, NoBodyOfAnyPortAndLengthIsMisread) {
  for (std::uint16_t port = 0; port <= kLastPort; ++port) {
    for (std::size_t size = 0; size <= kMaxBody; ++size) {
      for (const auto fill : {0x00U, 0x01U, 0x7fU, 0xffU}) {
        const auto once = rewritten(Port{port}, Bytes(size, static_cast<std::uint8_t>(fill)));
        if (!once || !*once) continue;
        const auto twice = rewritten(Port{port}, **once);
        ASSERT_TRUE(*twice) << to_string(Port{port}) << " of " << size << ": " << twice->error().text;
        ASSERT_EQ(**once, **twice) << to_string(Port{port}) << " of " << size;
      }
    }
  }
}

TEST(PeisWire, PortsHaveTheNamesOfTheReference) {
  EXPECT_EQ(to_string(Port::kSetRemote), "SET_REMOTE");
  EXPECT_EQ(to_string(Port{17}), "port 17");
}

}  // namespace
}  // namespace rubicon::tuples::peis
