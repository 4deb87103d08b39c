#include "networks/knx/wire/cemi.h"
#include "networks/knx/wire/hex.h"

#include <gtest/gtest.h>

namespace rubicon::networks::knx::wire {
namespace {

std::string written(const Telegram& telegram, CemiCode code = CemiCode::kDataRequest) {
  const auto cemi = write_telegram(code, telegram);
  return cemi ? base::to_hex(*cemi) : cemi.error().text;
}

Telegram telegram(Service service, std::uint16_t group, Payload payload = {}) {
  Telegram made;
  made.service = service;
  made.destination = GroupAddress{group};
  made.payload = std::move(payload);
  return made;
}

TEST(Cemi, GroupTelegramsAreWrittenAsMeasured) {
  EXPECT_EQ(written(telegram(Service::kWrite, 0x0a07, {{0x0c, 0x33}})), "1100bce000000a070300800c33");
  EXPECT_EQ(written(telegram(Service::kWrite, 0x0a03, {{1}, true})), "1100bce000000a03010081");
  EXPECT_EQ(written(telegram(Service::kRead, 0x0a05)), "1100bce000000a05010000");
  EXPECT_EQ(written(telegram(Service::kResponse, 0x0a05, {{1}, true})), "1100bce000000a05010041");
  auto received = telegram(Service::kWrite, 0x0a07, {{0x0c, 0x33}});
  received.source = IndividualAddress{0x11c8};
  received.hops = 5;
  EXPECT_EQ(written(received, CemiCode::kDataIndication), "2900bcd011c80a070300800c33");
}

TEST(Cemi, LongValuesMakeAnExtendedFrame) {
  EXPECT_EQ(written(telegram(Service::kWrite, 0x0a09, {bytes_of("4b4e582069732034204f4b2121212121")})),
            "11003ce000000a091100804b4e582069732034204f4b2121212121");
  EXPECT_EQ(written(telegram(Service::kWrite, 1, {Bytes(14, 7)})).substr(4, 2), "bc");
  EXPECT_EQ(written(telegram(Service::kWrite, 1, {Bytes(15, 7)})).substr(4, 2), "3c");
  const auto longest = write_telegram(CemiCode::kDataRequest, telegram(Service::kWrite, 1, {Bytes(253, 7)}));
  ASSERT_TRUE(longest);
  EXPECT_EQ((*longest)[8], 254);
  EXPECT_EQ(read_telegram(*longest)->payload.bytes.size(), 253U);
}

TEST(Cemi, AByteThatWouldFitTheSmallFormStaysAByte) {
  EXPECT_EQ(written(telegram(Service::kWrite, 1, {{1}})), "1100bce00000000102008001");
  const auto small = read_telegram(bytes_of("2900bce011010001010081"));
  ASSERT_TRUE(small);
  EXPECT_EQ(small->payload, (Payload{{1}, true}));
  const auto whole = read_telegram(bytes_of("2900bce01101000102008001"));
  ASSERT_TRUE(whole);
  EXPECT_EQ(whole->payload, (Payload{{1}, false}));
}

TEST(Cemi, WhatCannotBeSentIsRefused) {
  EXPECT_NE(written(telegram(Service::kWrite, 0, {{1}})).find("broadcast"), std::string::npos);
  EXPECT_NE(written(telegram(Service::kWrite, 1, {{64}, true})).find("0 to 63"), std::string::npos);
  EXPECT_NE(written(telegram(Service::kWrite, 1, {{1, 2}, true})).find("0 to 63"), std::string::npos);
  EXPECT_NE(written(telegram(Service::kWrite, 1)).find("0 bytes"), std::string::npos);
  EXPECT_NE(written(telegram(Service::kWrite, 1, {Bytes(254, 1)})).find("254 bytes"), std::string::npos);
  EXPECT_NE(written(telegram(Service::kRead, 1, {{1}})).find("no payload"), std::string::npos);
  auto far = telegram(Service::kRead, 1);
  far.hops = 8;
  EXPECT_NE(written(far).find("hop count 8"), std::string::npos);
}

TEST(Cemi, PrioritiesAndRepetitionsAreRead) {
  for (const auto& [control, priority] : {std::pair{"b0", Priority::kSystem}, std::pair{"b4", Priority::kNormal},
                                          std::pair{"b8", Priority::kUrgent}, std::pair{"bc", Priority::kLow}}) {
    const auto read = read_telegram(bytes_of("2900" + std::string(control) + "e011010001010081"));
    ASSERT_TRUE(read);
    EXPECT_EQ(read->priority, priority);
    EXPECT_FALSE(read->repeated);
    auto again = *read;
    EXPECT_EQ(written(again, CemiCode::kDataIndication).substr(4, 2), control);
  }
  EXPECT_TRUE(read_telegram(bytes_of("29009ce011010001010081"))->repeated);
}

TEST(Cemi, AdditionalInfoIsSkipped) {
  const auto read = read_telegram(bytes_of("29 06 04 04 01 02 03 04 bc d0 11c9 0a05 01 0041"));
  ASSERT_TRUE(read) << read.error().text;
  EXPECT_EQ(read->service, Service::kResponse);
  EXPECT_EQ(read->payload, (Payload{{1}, true}));
}

TEST(Cemi, ReceivingIsTolerantOfTheFrameType) {
  EXPECT_TRUE(read_telegram(bytes_of("29003ce011010001010081")));
  EXPECT_TRUE(read_telegram(bytes_of("2900bce01101000111008000000000000000000000000000000000")));
}

TEST(Cemi, FramesWithoutAGroupValueAreUnsupported) {
  for (const auto* hex : {
           "2900bc6011011102010000",  // to a device
           "2900b0e011010000010100",  // broadcast
           "2900bce011010001010400",  // tag group
           "2900bce011010001024301 01",
           "2900bce01101000100 80",   // connect
           "29003ce411010001010081",  // LTE
           "2900bce0110100010103d5",  // another APCI
       }) {
    const auto read = read_telegram(bytes_of(hex));
    ASSERT_FALSE(read) << hex;
    EXPECT_EQ(read.error().code, ErrorCode::kUnsupported) << hex;
  }
  EXPECT_EQ(read_telegram(bytes_of("fc0000010b1001")).error().code, ErrorCode::kUnsupported);
}

TEST(Cemi, BrokenFramesAreRefused) {
  for (const auto* hex : {"", "29", "2900", "2900bce0110100", "2900bce01101000102 0081", "2900bce011010001010081ff",
                          "2900bce01101000101", "29ffbce011010001010081", "29003ce0110100 01ff0081"}) {
    const auto read = read_data_frame(bytes_of(hex));
    ASSERT_FALSE(read) << hex;
    EXPECT_EQ(read.error().code, ErrorCode::kInvalid) << hex;
  }
}

TEST(Cemi, AConfirmationBelongsToItsRequestOnly) {
  const auto request = bytes_of("1100bce000000a070300800c33");
  EXPECT_TRUE(confirms(bytes_of("2e00bce000000a070300800c33"), request));
  EXPECT_TRUE(confirms(bytes_of("2e00bce011c80a070300800c33"), request)) << "the source was filled in";
  EXPECT_TRUE(confirms(bytes_of("2e00bde000000a070300800c33"), request)) << "negative";
  EXPECT_TRUE(confirms(bytes_of("2e00bcd000000a070300800c33"), request)) << "one hop less";
  EXPECT_TRUE(confirms(bytes_of("2e03030100bce000000a070300800c33"), request)) << "additional info";
  EXPECT_FALSE(confirms(bytes_of("2900bce000000a070300800c33"), request)) << "an indication";
  EXPECT_FALSE(confirms(bytes_of("2e00bcc000000a070300800c33"), request)) << "two hops less";
  EXPECT_FALSE(confirms(bytes_of("2e00bcf000000a070300800c33"), request)) << "one hop more";
  EXPECT_FALSE(confirms(bytes_of("2e00bc6000000a070300800c33"), request)) << "to a device";
  EXPECT_FALSE(confirms(bytes_of("2e00bce000000a080300800c33"), request)) << "another group";
  EXPECT_FALSE(confirms(bytes_of("2e00bce000000a070300800c34"), request)) << "another value";
  EXPECT_FALSE(confirms(bytes_of("2e00bce000000a0703008000"), request)) << "cut";
  EXPECT_FALSE(confirms({}, request));
  const auto from = bytes_of("1100bce011c80a070300800c33");
  EXPECT_FALSE(confirms(bytes_of("2e00bce011c90a070300800c33"), from)) << "another source";
  EXPECT_EQ(control1_of(bytes_of("2e00bde000000a070300800c33")), 0xbd);
}

TEST(Cemi, FramesAreDescribedInOneLine) {
  EXPECT_EQ(describe(bytes_of("2900bcd011c90a05010041")),
            "L_Data.ind low from 1.1.201 to 1/2/5 hops 5 GroupValueResponse (small) 01");
  EXPECT_EQ(describe(bytes_of("1100bce000000a070300800c33")),
            "L_Data.req low from 0.0.0 to 1/2/7 hops 6 GroupValueWrite 0C 33");
  EXPECT_EQ(describe(bytes_of("1100bce000000a05010000"), Notation::kTwoLevel),
            "L_Data.req low from 0.0.0 to 1/517 hops 6 GroupValueRead");
  EXPECT_EQ(describe(bytes_of("2e00bde000000a03010081")),
            "L_Data.con low not acknowledged from 0.0.0 to 1/2/3 hops 6 GroupValueWrite (small) 01");
  EXPECT_EQ(describe(bytes_of("29009ce011010a03010081")),
            "L_Data.ind low repeated from 1.1.1 to 1/2/3 hops 6 GroupValueWrite (small) 01");
  EXPECT_EQ(describe(bytes_of("2900b0e011010000010100")),
            "L_Data.ind system from 1.1.1 to broadcast hops 6 IndividualAddressRead");
  EXPECT_EQ(describe(bytes_of("2900b06011011102 05 47d5 000b 1001")),
            "L_Data.ind system from 1.1.1 to 1.1.2 hops 6 #1 PropertyValueRead 00 0B 10 01");
  EXPECT_EQ(describe(bytes_of("2900b0601101110200c2")), "L_Data.ind system from 1.1.1 to 1.1.2 hops 6 Ack 0");
  EXPECT_EQ(describe(bytes_of("fc0000010b1001")), "M_PropRead.req 00 00 01 0B 10 01");
  EXPECT_EQ(describe(bytes_of("2b0301bc11cc0a03e10081f7")).substr(0, 12), "L_Busmon.ind");
  EXPECT_NE(describe(bytes_of("2900bce0")).find("too few"), std::string::npos);
  EXPECT_EQ(describe({}), "empty frame");
}

}  // namespace
}  // namespace rubicon::networks::knx::wire
