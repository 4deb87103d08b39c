#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "networks/knx/line/tunnel_sockets.h"
#include "networks/knx/wire/blocks.h"
#include "networks/knx/wire/cemi.h"
#include "networks/knx/wire/hex.h"
#include "networks/knx/wire/message.h"

namespace rubicon::networks::knx::wire {
namespace {

/// A frame of knx.md, section 18: what it is written from and what it is read as.
template <class Body>
void expect_both_ways(std::string_view hex, const Body& body) {
  const auto bytes = bytes_of(hex);
  EXPECT_EQ(base::to_hex(write(Message(body))), base::to_hex(bytes));
  const auto read = read_message(bytes);
  ASSERT_TRUE(read) << read.error().text;
  const auto* as_read = std::get_if<Body>(&*read);
  ASSERT_NE(as_read, nullptr) << hex;
  EXPECT_EQ(*as_read, body) << hex;
}

const Hpai kClient{HostProtocol::kUdp, {10, 77, 0, 1}, 40100};
const Hpai kServer{HostProtocol::kUdp, {10, 77, 0, 1}, 3671};
const Hpai kStream{HostProtocol::kTcp, {}, 0};
constexpr IndividualAddress kTunnel{0x11c8};

TEST(Frames, SearchesAreWrittenAndReadAsMeasured) {
  expect_both_ways("06 10 02 01 00 0e 08 01 0a 4d 00 01 9c a4", SearchRequest{kClient});
  expect_both_ways("06 10 02 0b 00 14 08 01 0a 4d 00 01 9c a4 06 04 01 02 06 07",
                   SearchRequest{kClient, true, {{Srp::Type::kWantedDibs, false, {1, 2, 6, 7}}}});
  expect_both_ways("06 10 02 0b 00 10 08 01 00 00 00 00 00 00 02 81",
                   SearchRequest{{}, true, {{Srp::Type::kProgrammingMode, true, {}}}});
}

ServerDescription knxd() {
  ServerDescription knxd;
  knxd.medium = 2;
  knxd.address = IndividualAddress{0x11fa};
  knxd.serial = {1, 2, 3, 4, 5, 6};
  knxd.multicast = {224, 0, 23, 12};
  knxd.mac = {0x2a, 0x6c, 0x38, 0x3b, 0xd8, 0x12};
  knxd.name = "test-knxd";
  knxd.families = {{Family::kCore, 1}, {Family::kTunnelling, 1}, {Family::kRouting, 1}};
  return knxd;
}

TEST(Frames, TheSearchAnswerOfKnxdIsWrittenAndReadAsMeasured) {
  const auto hex =
      "06 10 02 02 00 4c 08 01 0a 4d 00 01 0e 57 36 01 02 00 11 fa 00 00 01 02 03 04 05 06 e0 00 17 0c"
      "2a 6c 38 3b d8 12 74 65 73 74 2d 6b 6e 78 64" +
      std::string(42, '0') + "08 02 02 01 04 01 05 01";
  expect_both_ways(hex, SearchResponse{kServer, false, to_dibs(knxd())});
  const auto read = read_message(bytes_of(hex));
  const auto description = read_description(std::get<SearchResponse>(*read).dibs);
  EXPECT_EQ(description, knxd());
  EXPECT_EQ(description.version(Family::kTunnelling), 1);
  EXPECT_EQ(description.version(Family::kSecurity), 0);
}

TEST(Frames, TunnellingBlocksListFreeSlots) {
  const auto bytes = bytes_of("18 07 00 0f 71 0b ff ff 71 0a ff ff 71 0d ff fe 71 0c ff fd 71 0e ff fb");
  base::ByteReader reader(bytes);
  const auto dibs = read_dibs(reader);
  ASSERT_TRUE(dibs);
  const auto read = read_description(*dibs);
  EXPECT_EQ(read.max_apdu, 15);
  ASSERT_EQ(read.slots.size(), 5U);
  EXPECT_EQ(read.slots[0], (TunnelSlot{IndividualAddress{0x710b}, true, true, true}));
  EXPECT_FALSE(read.slots[2].free);
  EXPECT_FALSE(read.slots[3].authorised);
  EXPECT_FALSE(read.slots[4].usable);
  EXPECT_EQ(to_dibs(read).back(), dibs->front());
}

TEST(Frames, AnInvalidBlockDoesNotHideAServer) {
  const auto good = to_dibs(knxd());
  for (const auto* hex : {"05 01 02 00 11", "03 02 02", "03 06 02", "03 05 11", "05 07 00 0f 71", "01", "02 fe"}) {
    auto bytes = bytes_of(hex);
    for (const auto& dib : good) write(bytes, dib);
    base::ByteReader reader(bytes);
    const auto dibs = read_dibs(reader);
    ASSERT_TRUE(dibs) << hex;
    EXPECT_EQ(read_description(*dibs), knxd()) << hex;
  }
}

TEST(Frames, NamesCarryNoControlCharacters) {
  auto dibs = to_dibs(knxd());
  const auto name = bytes_of("1b 5b 32 4a 07 41 7f 80 9f a0 e9 0a 00");
  std::copy(name.begin(), name.end(), dibs[0].content.end() - 30);
  EXPECT_EQ(read_description(dibs).name, "?[2J?A???\xc2\xa0\xc3\xa9?");
}

TEST(Frames, ConnectionsAreWrittenAndReadAsMeasured) {
  expect_both_ways("06 10 02 05 00 1a 08 01 0a 4d 00 01 9c a4 08 01 0a 4d 00 01 9c a4 04 04 02 00",
                   ConnectRequest{kClient, kClient});
  expect_both_ways("06 10 02 06 00 14 01 00 08 01 0a 4d 00 01 0e 57 04 04 11 c8",
                   ConnectResponse{1, 0, kServer, {ConnectionType::kTunnel, kTunnel}});
  expect_both_ways("06 10 02 06 00 08 00 24", ConnectResponse{0, 0x24});
  expect_both_ways("06 10 02 06 00 08 00 29", ConnectResponse{0, 0x29});
  expect_both_ways(
      "06 10 02 05 00 1c 08 02 00 00 00 00 00 00 08 02 00 00 00 00 00 00 06 04 02 00 71 0c",
      ConnectRequest{kStream, kStream, {ConnectionType::kTunnel, TunnelLayer::kLink, IndividualAddress{0x710c}}});
  expect_both_ways("06 10 02 06 00 14 01 00 08 02 00 00 00 00 00 00 04 04 71 0c",
                   ConnectResponse{1, 0, kStream, {ConnectionType::kTunnel, IndividualAddress{0x710c}}});
  expect_both_ways("06 10 02 05 00 18 08 01 0a 4d 00 01 9c a4 08 01 0a 4d 00 01 9c a4 02 03",
                   ConnectRequest{kClient, kClient, {ConnectionType::kDeviceManagement}});
}

TEST(Frames, HeartbeatsAndDisconnectsAreWrittenAndReadAsMeasured) {
  expect_both_ways("06 10 02 07 00 10 01 00 08 01 0a 4d 00 01 9c a4", ConnectionStateRequest{1, kClient});
  expect_both_ways("06 10 02 08 00 08 01 00", ConnectionStateResponse{1, 0});
  expect_both_ways("06 10 02 07 00 10 63 00 08 01 0a 4d 00 01 9c a4", ConnectionStateRequest{0x63, kClient});
  expect_both_ways("06 10 02 08 00 08 63 21", ConnectionStateResponse{0x63, 0x21});
  expect_both_ways("06 10 02 09 00 10 01 00 08 01 0a 4d 00 01 9c a4", DisconnectRequest{1, kClient});
  expect_both_ways("06 10 02 0a 00 08 01 00", DisconnectResponse{1, 0});
  expect_both_ways("06 10 02 09 00 10 01 00 08 01 00 00 00 00 00 00", DisconnectRequest{1, {}});
  EXPECT_TRUE(Hpai{}.route_back());
  EXPECT_FALSE(kClient.route_back());
}

/// A frame of tunnelling, routing or management around a cEMI frame.
struct Wrapped {
  const char* frame;
  ServiceCode service;
  ConnectionHeader header;
  const char* cemi;
};
const Wrapped kWrapped[] = {
    {"06 10 04 20 00 17 04 01 00 00 11 00 bc e0 00 00 0a 07 03 00 80 0c 33",
     ServiceCode::kTunnellingRequest,
     {1, 0, 0},
     "1100bce000000a070300800c33"},
    {"06 10 04 20 00 17 04 01 00 00 2e 00 bc e0 00 00 0a 07 03 00 80 0c 33",
     ServiceCode::kTunnellingRequest,
     {1, 0, 0},
     "2e00bce000000a070300800c33"},
    {"06 10 04 20 00 15 04 01 02 00 11 00 bc e0 00 00 0a 05 01 00 00",
     ServiceCode::kTunnellingRequest,
     {1, 2, 0},
     "1100bce000000a05010000"},
    {"06 10 04 20 00 15 04 01 03 00 29 00 bc d0 11 c9 0a 05 01 00 41",
     ServiceCode::kTunnellingRequest,
     {1, 3, 0},
     "2900bcd011c90a05010041"},
    {"06 10 03 10 00 11 04 01 00 00 fc 00 00 01 0b 10 01",
     ServiceCode::kDeviceConfigurationRequest,
     {1, 0, 0},
     "fc0000010b1001"},
};

TEST(Frames, RequestsAroundCemiAreWrittenAndReadAsMeasured) {
  for (const auto& [hex, service, header, cemi_hex] : kWrapped) {
    const auto frame = bytes_of(hex), cemi = bytes_of(cemi_hex);
    EXPECT_EQ(write(ConnectionRequest{service, header, cemi}), frame);
    const auto read = read_message(frame);
    ASSERT_TRUE(read) << hex;
    const auto& request = std::get<ConnectionRequest>(*read);
    EXPECT_EQ(request.service, service);
    EXPECT_EQ(request.header, header);
    EXPECT_EQ(Bytes(request.cemi.begin(), request.cemi.end()), cemi);
    Bytes reused{1, 2, 3};
    write_connection_request(reused, service, header, cemi);
    EXPECT_EQ(reused, frame);
  }
}

TEST(Frames, AcksAreWrittenAndReadAsMeasured) {
  for (const auto& [hex, header] : {std::pair{"06 10 04 21 00 0a 04 01 00 00", ConnectionHeader{1, 0, 0}},
                                    std::pair{"06 10 04 21 00 0a 04 01 04 29", ConnectionHeader{1, 4, 0x29}}}) {
    Bytes frame;
    write_connection_ack(frame, ServiceCode::kTunnellingAck, header);
    EXPECT_EQ(frame, bytes_of(hex));
    const auto read = read_message(frame);
    ASSERT_TRUE(read);
    EXPECT_EQ(std::get<ConnectionAck>(*read).header, header);
    EXPECT_EQ(write(*read), frame);
  }
}

TEST(Frames, FeaturesAreWrittenAndReadAsMeasured) {
  const auto get = bytes_of("06 10 04 22 00 0c 04 01 05 00 06 00");
  EXPECT_EQ(write(FeatureMessage{ServiceCode::kFeatureGet, {1, 5, 0}, 6, 0, {}}), get);
  const auto response = bytes_of("06 10 04 23 00 0e 04 01 00 00 06 00 71 0c");
  const auto read = read_message(response);
  ASSERT_TRUE(read);
  const auto& feature = std::get<FeatureMessage>(*read);
  EXPECT_EQ(feature.service, ServiceCode::kFeatureResponse);
  EXPECT_EQ(feature.feature, 6);
  EXPECT_EQ(base::to_hex(feature.value), "710c");
  EXPECT_EQ(write(*read), response);
}

TEST(Frames, RoutingIsWrittenAndReadAsMeasured) {
  const auto busy = read_message(bytes_of("06 10 05 32 00 0c 06 00 00 64 00 00"));
  ASSERT_TRUE(busy);
  EXPECT_EQ(std::get<RoutingBusy>(*busy).wait, 100);
  EXPECT_EQ(std::get<RoutingBusy>(*busy).control, 0);
  EXPECT_EQ(base::to_hex(write(*busy)), "06100532000c060000640000");
  const auto lost = read_message(bytes_of("06 10 05 31 00 0a 04 00 00 05"));
  ASSERT_TRUE(lost);
  EXPECT_EQ(std::get<RoutingLostMessage>(*lost).lost, 5);
  EXPECT_EQ(base::to_hex(write(*lost)), "06100531000a04000005");
  const auto indication = bytes_of("06 10 05 30 00 13 29 00 bc d0 11 c8 0a 07 03 00 80 0c 33");
  const auto read = read_message(indication);
  ASSERT_TRUE(read);
  EXPECT_EQ(write(*read), indication);
  const auto telegram = read_telegram(std::get<RoutingIndication>(*read).cemi);
  ASSERT_TRUE(telegram);
  EXPECT_EQ(telegram->hops, 5);
  EXPECT_EQ(write(RoutingIndication{bytes_of("29"), true})[3], 0x33);
}

TEST(Frames, SecureServicesAreDispatchedByTheirCodeOnly) {
  const auto frame = bytes_of("06100954000800 00");
  const auto read = read_message(frame);
  ASSERT_TRUE(read);
  EXPECT_EQ(std::get<OtherService>(*read).service, ServiceCode::kSessionStatus);
  EXPECT_EQ(to_string(ServiceCode::kSecureWrapper), "SECURE_WRAPPER");
  EXPECT_EQ(to_string(ServiceCode{0x0538}), "service 0538");
  EXPECT_EQ(write(*read), frame);
}

struct Broken {
  const char* hex;
  const char* expected;
};
const Broken kBroken[] = {
    {"", "0 bytes"},
    {"06 10 02 01 00", "5 bytes"},
    {"05 10 02 08 00 08 01 00", "header of size 5"},
    {"06 20 02 08 00 08 01 00", "version 20, expected 10"},
    {"06 10 02 08 00 09 01 00", "total length 9, but 8 bytes came"},
    {"06 10 02 08 00 05 01 00", "total length 5"},
    {"06 10 02 08 00 07 01", "CONNECTIONSTATE_RESPONSE: body: too short"},
    {"06 10 02 01 00 0e 07 01 0a 4d 00 01 9c a4", "SEARCH_REQUEST: HPAI: length 7, expected 8"},
    {"06 10 02 01 00 0e 08 03 0a 4d 00 01 9c a4", "HPAI: protocol 3"},
    {"06 10 02 01 00 0d 08 01 0a 4d 00 01 9c", "HPAI: goes beyond the end"},
    {"06 10 02 06 00 13 01 00 08 01 0a 4d 00 01 0e 57 04 04 11", "CRD: goes beyond the end"},
    {"06 10 02 06 00 14 01 00 08 01 0a 4d 00 01 0e 57 04 06 11 c8", "CRD: connection type 06"},
    {"06 10 02 04 00 08 00 01", "DIB: length 0"},
    {"06 10 02 04 00 08 03 01", "DIB: goes beyond the end"},
    {"06 10 02 0b 00 10 08 01 00 00 00 00 00 00 03 81", "SRP: goes beyond the end"},
    {"06 10 04 20 00 0a 05 01 00 00", "connection header: length 5"},
    {"06 10 04 20 00 09 04 01 00", "connection header: goes beyond the end"},
    {"06 10 05 32 00 0c 05 00 00 64 00 00", "ROUTING_BUSY: body: length 5, expected 6"},
    {"06 10 05 31 00 08 04 00", "ROUTING_LOST_MESSAGE: body: too short"},
};

TEST(Frames, BrokenFramesAreRefusedWithTheReason) {
  for (const auto& [hex, expected] : kBroken) {
    const auto read = read_message(bytes_of(hex));
    ASSERT_FALSE(read) << hex;
    EXPECT_NE(read.error().text.find(expected), std::string::npos) << hex << ": " << read.error().text;
  }
}

TEST(Frames, StreamsAreCutByTheTotalLength) {
  const auto frame = bytes_of("06100208000801000610");
  EXPECT_EQ(*frame_size(ByteView(frame).first(0)), 0U);
  EXPECT_EQ(*frame_size(ByteView(frame).first(5)), 0U);
  EXPECT_EQ(*frame_size(ByteView(frame).first(6)), 8U);
  EXPECT_EQ(*frame_size(frame), 8U);
  EXPECT_FALSE(frame_size(bytes_of("07")));
  EXPECT_FALSE(frame_size(bytes_of("0611")));
  EXPECT_FALSE(frame_size(bytes_of("061002080000")));
}

TEST(Frames, AStreamWithoutAHeaderIsDetectedEarly) {
  line::FrameStream stream;
  stream.append(bytes_of("061004200800"));
  EXPECT_TRUE(stream.next()) << "2048 bytes: more to come";
  stream.clear();
  stream.append(bytes_of("061004200801"));
  const auto next = stream.next();
  ASSERT_FALSE(next);
  EXPECT_NE(next.error().text.find("2049, expected at most 2048"), std::string::npos);
}

TEST(Frames, OnlyAddressesOfFourNumbersAreEndpoints) {
  EXPECT_EQ(udp_hpai("10.77.0.1", 40100), kClient);
  for (const auto* text : {"", "10.77.0", "10.77.0.1.2", "10.77.0.256", "::1", "a.b.c.d", "10.77.0.1 "})
    EXPECT_TRUE(udp_hpai(text, 1).route_back()) << text;
  EXPECT_EQ(address_text(kClient), "10.77.0.1");
}

TEST(Frames, EveryKnownStatusHasWords) {
  for (const int code : {0x01, 0x02, 0x04, 0x0f, 0x21, 0x22, 0x23, 0x24, 0x25, 0x26, 0x27, 0x28, 0x29, 0x2d, 0x2e})
    EXPECT_NE(meaning_of(static_cast<std::uint8_t>(code)).meaning, "unknown status") << code;
  EXPECT_EQ(describe_status(0x24), "all tunnels of the interface are in use (status 24)");
  EXPECT_EQ(meaning_of(0x24).remedy, Remedy::kWaitForSlot);
  EXPECT_EQ(meaning_of(0x2d).remedy, Remedy::kConfiguration);
  EXPECT_EQ(meaning_of(0x77).remedy, Remedy::kRetry);
}

/// Every frame of the captures beside the source tree, if they are there.
TEST(Frames, AllCapturedFramesAreWrittenAsTheyWereRead) {
  const auto path = std::filesystem::path(RUBICON_SOURCE_DIR).parent_path() / "shared/data/knx/frames.tsv";
  std::ifstream file(path);
  if (!file) GTEST_SKIP() << "no captures at " << path;
  std::size_t frames = 0;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with('#')) continue;
    std::istringstream columns(line);
    std::string capture, seconds, transport, direction, hex, service;
    for (auto* column : {&capture, &seconds, &transport, &direction, &hex, &service})
      std::getline(columns, *column, '\t');
    const auto bytes = bytes_of(hex);
    const auto read = read_message(bytes);
    ASSERT_TRUE(read) << hex << ": " << read.error().text;
    EXPECT_EQ(base::to_hex(write(*read)), base::to_hex(bytes));
    EXPECT_EQ(to_string(read_frame(bytes)->service), service);
    ++frames;
    const auto* request = std::get_if<ConnectionRequest>(&*read);
    if (request == nullptr) continue;
    const auto data = read_data_frame(request->cemi);
    if (!data) continue;
    EXPECT_EQ(base::to_hex(write(*data)), base::to_hex(request->cemi));
  }
  EXPECT_GT(frames, 200U);
}

}  // namespace
}  // namespace rubicon::networks::knx::wire
