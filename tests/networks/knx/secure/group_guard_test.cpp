#include "networks/knx/secure/group_guard.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "networks/knx/secure/guard_bench.h"

namespace rubicon::networks::knx::secure {
namespace {

using namespace std::chrono_literals;
using Drop = GroupGuard::Drop;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using wire::CemiCode;

constexpr wire::GroupAddress kPlainGroup{0x2404};

std::uint64_t sequence_of(ByteView cemi) {
  return read_secured(wire::read_data_frame(cemi).value().tpdu).value().sequence;
}

TEST(GroupGuard, WhatOneGuardProtectsAnotherOpens) {
  GuardBench here, there;
  here.start();
  there.start(one_group(), kOther);
  for (const auto service : {wire::Service::kRead, wire::Service::kResponse, wire::Service::kWrite}) {
    for (const std::size_t size : {1U, 2U, 14U, 200U}) {
      auto telegram = value_for(kSecuredGroup, Bytes(size, 0x5a));
      telegram.service = service;
      telegram.priority = wire::Priority::kUrgent;
      if (service == wire::Service::kRead) telegram.payload = {};
      const auto cemi = here.guard->protect(CemiCode::kDataIndication, telegram, kOwn);
      ASSERT_TRUE(cemi) << cemi.error().text;
      EXPECT_EQ(wire::read_data_frame(*cemi)->extended(), cemi->size() > 9 + 16);
      const auto received = opened(*there.guard, *cemi);
      ASSERT_TRUE(received) << received.error().why;
      telegram.source = kOwn;
      EXPECT_EQ(*received, telegram);
    }
  }
  EXPECT_EQ(here.count("data-secure-sent"), 12U);
  EXPECT_EQ(there.count("data-secure-received"), 12U);
}

TEST(GroupGuard, TwoBytesNeedAnExtendedFrameAndOneDoesNot) {
  GuardBench bench;
  bench.start();
  bench.disk.store_own(4);
  bench.time.set_wall({});
  auto& guard = bench.start();
  EXPECT_EQ(base::to_hex(*guard.protect(CemiCode::kDataRequest, value_for(kSecuredGroup, {0x80}), kOwn)).substr(0, 26),
            "1100bce0110a0a070f03f11000");
  EXPECT_EQ(base::to_hex(*guard.protect(CemiCode::kDataRequest, value_for(kSecuredGroup), kOwn)).substr(0, 26),
            "11003ce0110a0a071003f11000");
}

TEST(GroupGuard, OtherGroupsPassUnchanged) {
  GuardBench bench;
  auto& guard = bench.start();
  const auto telegram = value_for(kPlainGroup);
  const auto cemi = guard.protect(CemiCode::kDataRequest, telegram, kOwn);
  EXPECT_EQ(*cemi, *wire::write_telegram(CemiCode::kDataRequest, telegram));
  EXPECT_EQ(opened(guard, *cemi).value(), telegram);
  EXPECT_EQ(bench.disk.writes, 0) << "no sequence number was needed";
}

TEST(GroupGuard, ASecuredGroupTakesNoPlainTelegram) {
  GuardBench bench;
  auto& guard = bench.start();
  const auto plain = wire::write_telegram(CemiCode::kDataIndication, value_for(kSecuredGroup)).value();
  const auto result = opened(guard, plain);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().drop, Drop::kPlain);
  EXPECT_THAT(result.error().why, HasSubstr("0.0.0 to 1/2/7"));
  EXPECT_EQ(bench.count("data-secure-plain-dropped"), 1U);
}

TEST(GroupGuard, RepeatedAndOlderTelegramsAreDropped) {
  GuardBench bench;
  auto& guard = bench.start();
  const auto good = indication(kOther, 5, value_for(kSecuredGroup));
  EXPECT_TRUE(opened(guard, good));
  EXPECT_EQ(opened(guard, good).error().drop, Drop::kOldSequence);
  EXPECT_EQ(opened(guard, indication(kOther, 4, value_for(kSecuredGroup))).error().drop, Drop::kOldSequence);
  EXPECT_THAT(opened(guard, good).error().why, HasSubstr("number 5, but 5 was valid before"));
  EXPECT_TRUE(opened(guard, indication(wire::IndividualAddress(0x110c), 4, value_for(kSecuredGroup))))
      << "each sender counts for itself";
  EXPECT_TRUE(opened(guard, indication(kOther, kMaxSequence, value_for(kSecuredGroup))));
  EXPECT_EQ(bench.count("data-secure-old"), 3U);
}

TEST(GroupGuard, SequenceZeroIsNeverValid) {
  GuardBench bench;
  EXPECT_EQ(opened(bench.start(), indication(kOther, 0, value_for(kSecuredGroup))).error().drop, Drop::kOldSequence);
}

TEST(GroupGuard, AForgedNumberChangesNothing) {
  GuardBench bench;
  auto& guard = bench.start();
  const auto forged = indication(kOther, 1000, value_for(kSecuredGroup), Key(counting(0x31, 16).view()));
  EXPECT_EQ(opened(guard, forged).error().drop, Drop::kWrongMac);
  EXPECT_TRUE(opened(guard, indication(kOther, 7, value_for(kSecuredGroup))));
}

TEST(GroupGuard, OnlyTheSendersOfTheGroupAreAccepted) {
  GuardBench bench;
  auto keys = one_group();
  keys.groups[wire::GroupAddress(0x1001)] = {keys.groups[kSecuredGroup].key, {kOther}};
  auto& guard = bench.start(std::move(keys));
  const wire::IndividualAddress third{0x110c};
  EXPECT_TRUE(opened(guard, indication(third, 9, value_for(kSecuredGroup))));
  EXPECT_EQ(opened(guard, indication(third, 10, value_for(wire::GroupAddress(0x1001)))).error().drop,
            Drop::kUnknownSender);
}

TEST(GroupGuard, WhatIsNotHandledIsCountedByItsKind) {
  GuardBench bench;
  auto& guard = bench.start();
  const auto with = [&](std::uint8_t scf) { return indication(kOther, 9, value_for(kSecuredGroup), {}, scf); };
  EXPECT_EQ(opened(guard, with(0x90)).error().drop, Drop::kToolAccess);
  EXPECT_EQ(opened(guard, with(0x12)).error().drop, Drop::kSync);
  EXPECT_EQ(opened(guard, with(0x13)).error().drop, Drop::kSync);
  EXPECT_EQ(opened(guard, with(0x18)).error().drop, Drop::kOther) << "system broadcast";
  EXPECT_EQ(opened(guard, with(0x11)).error().drop, Drop::kOther) << "a service of no meaning";
  EXPECT_EQ(opened(guard, with(0x20)).error().drop, Drop::kOther) << "an algorithm of no meaning";
  const auto good = with(0x10);
  auto to_device = wire::read_data_frame(good).value();
  to_device.control2 = 0x60;
  EXPECT_EQ(guard.open(to_device).error().drop, Drop::kPointToPoint);
  EXPECT_EQ(bench.count("data-secure-tool-access"), 1U);
  EXPECT_EQ(bench.count("data-secure-synchronisation"), 2U);
  EXPECT_EQ(bench.count("data-secure-point-to-point"), 1U);
  EXPECT_EQ(bench.count("data-secure-other"), 3U);
}

TEST(GroupGuard, AGoodTelegramWithoutAGroupValueIsDroppedAndItsNumberIsUsed) {
  GuardBench bench;
  auto& guard = bench.start();
  const auto tpdu = hex("03d500");  // PropertyValueRead to a group
  wire::DataFrame frame;
  frame.source = kOther;
  frame.destination = number(kSecuredGroup);
  frame.tpdu = tpdu;
  Ccm ccm;
  const auto sealed = seal(ccm, Key(counting(0x30, 16).view()), frame, control::kEncrypted, 9).value();
  frame.tpdu = sealed;
  EXPECT_EQ(guard.open(frame).error().drop, Drop::kOther);
  EXPECT_EQ(guard.open(frame).error().drop, Drop::kOldSequence);
}

TEST(GroupGuard, FramesThatAreNoTelegramAreNoMatterOfSecurity) {
  GuardBench bench;
  auto& guard = bench.start();
  const auto connect = hex("2900b060110b110a0080");
  const auto result = opened(guard, connect);
  EXPECT_EQ(result.error().drop, Drop::kNoTelegram);
  EXPECT_EQ(result.error().counter(), "");
  for (const auto& [name, value] : guard.counters()) EXPECT_EQ(value, 0U) << name;
}

TEST(GroupGuard, AGroupWithoutAKeyIsClosedBothWays) {
  GuardBench bench;
  auto keys = one_group();
  keys.groups[kSecuredGroup].key.reset();
  auto& guard = bench.start(std::move(keys));
  const auto refused = guard.protect(CemiCode::kDataRequest, value_for(kSecuredGroup), kOwn);
  EXPECT_EQ(refused.error().code, ErrorCode::kRefused);
  EXPECT_THAT(refused.error().text, HasSubstr("1/2/7 is secured, and its key is not known"));
  EXPECT_EQ(opened(guard, indication(kOther, 9, value_for(kSecuredGroup))).error().drop, Drop::kNoKey);
  EXPECT_EQ(opened(guard, indication(kOther, 9, value_for(kPlainGroup))).error().drop, Drop::kNoKey)
      << "a group that we do not know as secured";
}

TEST(GroupGuard, WithoutStorageSecuredGroupsAreReadOnly) {
  GuardBench bench;
  auto& guard = bench.start(one_group(), GroupStorage{});
  EXPECT_FALSE(guard.can_send());
  const auto refused = guard.protect(CemiCode::kDataRequest, value_for(kSecuredGroup), kOwn);
  EXPECT_EQ(refused.error().code, ErrorCode::kRefused);
  EXPECT_THAT(refused.error().text, HasSubstr("1/2/7 is secured, and nothing can be sent to it"));
  EXPECT_THAT(refused.error().text, HasSubstr("no state file"));
  EXPECT_TRUE(opened(guard, indication(kOther, 9, value_for(kSecuredGroup))));
  EXPECT_FALSE(opened(guard, indication(kOther, 9, value_for(kSecuredGroup)))) << "replays are dropped all the same";
  bench.guard.reset();
  EXPECT_THAT(bench.notes, IsEmpty()) << "nothing is wrong with receiving";
}

TEST(GroupGuard, WithoutALinkOrAnOwnAddressNothingIsSent) {
  GuardBench bench;
  auto keys = one_group();
  keys.groups[kSecuredGroup].may_send.emplace();
  EXPECT_THAT(bench.start(keys).protect(CemiCode::kDataRequest, value_for(kSecuredGroup), kOwn).error().text,
              HasSubstr("no link between it and 1.1.10"));
  EXPECT_THAT(bench.start().protect(CemiCode::kDataRequest, value_for(kSecuredGroup), {}).error().text,
              HasSubstr("no address to send from"));
}

TEST(GroupGuard, TheAddressOfTheLineDecidesWhoMaySendAndBeHeard) {
  GuardBench bench;
  auto keys = one_group();
  auto& entry = keys.groups[kSecuredGroup];
  entry.may_send = {kOwn};
  entry.senders = {kOther, kOwn};
  entry.senders_for[kOwn] = {};
  keys.sequences[kOwn] = 1ULL << 47U;
  auto& guard = bench.start(keys);
  const wire::IndividualAddress elsewhere{0x1177};
  EXPECT_FALSE(guard.protect(CemiCode::kDataRequest, value_for(kSecuredGroup), elsewhere));
  const auto sent = guard.protect(CemiCode::kDataRequest, value_for(kSecuredGroup), kOwn).value();
  EXPECT_EQ(read_secured(wire::read_data_frame(sent)->tpdu)->sequence, (1ULL << 47U) + 1) << "the known number counts";
  const auto cemi = indication(kOther, 9, value_for(kSecuredGroup));
  const auto telegram = wire::read_data_frame(cemi).value();
  EXPECT_EQ(guard.open(telegram, kOwn).error().drop, GroupGuard::Drop::kUnknownSender);
  EXPECT_TRUE(guard.open(telegram, elsewhere));
}

TEST(GroupGuard, AMonitorDecodesWithoutAnyEffect) {
  GuardBench bench;
  auto& guard = bench.start();
  const wire::IndividualAddress stranger{0x1199};
  const auto cemi = indication(stranger, 9, value_for(kSecuredGroup));
  const auto frame = wire::read_data_frame(cemi).value();
  for (int i = 0; i < 2; ++i) {
    const auto peeked = guard.peek(frame);
    ASSERT_TRUE(peeked) << peeked.error().text;
    EXPECT_TRUE(peeked->secured);
    EXPECT_EQ(peeked->sequence, 9U);
    EXPECT_EQ(peeked->telegram.payload.bytes, (Bytes{0x0c, 0x33}));
  }
  for (const auto& [name, value] : guard.counters()) EXPECT_EQ(value, 0U) << name;
  const auto plain = wire::write_telegram(CemiCode::kDataIndication, value_for(kSecuredGroup)).value();
  EXPECT_FALSE(guard.peek(wire::read_data_frame(plain).value())->secured);
  const auto own = guard.protect(CemiCode::kDataRequest, value_for(kSecuredGroup), kOwn).value();
  EXPECT_TRUE(guard.peek(wire::read_data_frame(own).value())->secured) << "also what we send";
}

// Keys without a list of senders.

GroupKeys for_any_sender() {
  auto keys = one_group();
  keys.groups[kSecuredGroup].senders.clear();
  keys.groups[kSecuredGroup].any_sender = true;
  return keys;
}

TEST(GroupGuard, WithoutAListEachSenderCountsForItself) {
  GuardBench bench;
  auto& guard = bench.start(for_any_sender());
  const wire::IndividualAddress far{0x2203};
  EXPECT_TRUE(opened(guard, indication(kOther, 9, value_for(kSecuredGroup))));
  EXPECT_TRUE(opened(guard, indication(far, 3, value_for(kSecuredGroup))));
  EXPECT_EQ(opened(guard, indication(far, 3, value_for(kSecuredGroup))).error().drop, Drop::kOldSequence);
  EXPECT_EQ(opened(guard, indication(kOther, 8, value_for(kSecuredGroup))).error().drop, Drop::kOldSequence);
  EXPECT_EQ(opened(guard, indication(far, 9, value_for(kSecuredGroup), Key(counting(0x31, 16).view()))).error().drop,
            Drop::kWrongMac);
}

TEST(GroupGuard, NumbersOfSendersWithoutAListSurviveARestart) {
  GuardBench bench;
  bench.start(for_any_sender());
  const wire::IndividualAddress same_line{0x11c9}, far{0x2203};
  for (const auto sender : {kOther, same_line, far})
    EXPECT_TRUE(opened(*bench.guard, indication(sender, 9, value_for(kSecuredGroup))));
  bench.start(for_any_sender());
  EXPECT_EQ(opened(*bench.guard, indication(kOther, 9, value_for(kSecuredGroup))).error().drop, Drop::kOldSequence);
  EXPECT_TRUE(opened(*bench.guard, indication(kOther, 10, value_for(kSecuredGroup))));
  bench.start(for_any_sender());
  for (const auto sender : {same_line, far}) {
    EXPECT_EQ(opened(*bench.guard, indication(sender, 9, value_for(kSecuredGroup))).error().drop, Drop::kOldSequence)
        << "also where only another sender of its line was heard";
  }
}

TEST(GroupGuard, OurOwnTelegramsThatWereRecordedAreOld) {
  GuardBench bench;
  auto& guard = bench.start();
  const auto own = guard.protect(CemiCode::kDataIndication, value_for(kSecuredGroup), kOwn);
  ASSERT_TRUE(own);
  EXPECT_EQ(opened(guard, *own, kOwn).error().drop, Drop::kOldSequence);
  EXPECT_EQ(opened(bench.start(), *own, kOwn).error().drop, Drop::kOldSequence) << "after a restart";
}

// What is kept.

TEST(GroupGuard, LastNumbersOfSendersSurviveARestart) {
  GuardBench bench;
  bench.start();
  EXPECT_TRUE(opened(*bench.guard, indication(kOther, 9, value_for(kSecuredGroup))));
  bench.start();
  EXPECT_EQ(opened(*bench.guard, indication(kOther, 9, value_for(kSecuredGroup))).error().drop, Drop::kOldSequence);
  EXPECT_TRUE(opened(*bench.guard, indication(kOther, 10, value_for(kSecuredGroup))));
}

TEST(GroupGuard, LastNumbersAreWrittenAtMostEachTenSeconds) {
  GuardBench bench;
  bench.start();
  for (std::uint64_t i = 1; i <= 1000; ++i) {
    EXPECT_TRUE(opened(*bench.guard, indication(kOther, i, value_for(kSecuredGroup))));
    bench.time.run_for(100ms);
  }
  EXPECT_LE(bench.disk.soon_writes, 11);
  EXPECT_GE(bench.disk.soon_writes, 10);
  EXPECT_EQ(bench.disk.writes, 2) << "that wait for the disk, in 100 s";
}

TEST(GroupGuard, TheSendersOfAllLinesWaitForTheDiskTogetherAndOnce) {
  GuardBench bench;
  auto keys = one_group();
  std::vector<wire::IndividualAddress> senders;
  for (unsigned line = 1; line <= 15; ++line)
    senders.push_back(wire::IndividualAddress(static_cast<std::uint16_t>(line << 8U | 7U)));
  keys.groups[kSecuredGroup].senders = {senders.begin(), senders.end()};
  bench.start(keys);
  for (const auto sender : senders) EXPECT_TRUE(opened(*bench.guard, indication(sender, 9, value_for(kSecuredGroup))));
  bench.time.run_for(1s);
  EXPECT_EQ(bench.disk.soon_writes, 15);
  EXPECT_EQ(bench.disk.writes, 1);
  EXPECT_TRUE(opened(*bench.guard, indication(senders[0], 10, value_for(kSecuredGroup))));
  bench.time.run_for(1h);
  EXPECT_EQ(bench.disk.writes, 2) << "the last number is on the disk too, though nothing follows";
}

/// Else the next write would replace the good numbers of all other senders.
TEST(GroupGuard, AReadOfLastNumbersThatFailsOnceForgetsNothing) {
  GuardBench bench;
  bench.start();
  const wire::IndividualAddress third{0x110c};
  for (const auto sender : {kOther, third})
    EXPECT_TRUE(opened(*bench.guard, indication(sender, 9, value_for(kSecuredGroup))));
  bench.guard.reset();
  auto storage = bench.disk.storage();
  bool broken = true;
  storage.stored = [&broken, read = storage.stored](std::string_view name) -> Result<std::optional<Bytes>> {
    if (broken) return fail(ErrorCode::kIo, "state file is locked");
    return read(name);
  };
  bench.start(one_group(), storage);
  const auto unknown = opened(*bench.guard, indication(kOther, 10, value_for(kSecuredGroup)));
  ASSERT_FALSE(unknown) << "its last number is not known";
  EXPECT_EQ(unknown.error().drop, Drop::kOldSequence);
  EXPECT_THAT(unknown.error().why, HasSubstr("state file is locked"));
  broken = false;
  EXPECT_TRUE(opened(*bench.guard, indication(kOther, 10, value_for(kSecuredGroup))));
  bench.start();
  EXPECT_FALSE(opened(*bench.guard, indication(third, 9, value_for(kSecuredGroup))));
  EXPECT_FALSE(opened(*bench.guard, indication(kOther, 10, value_for(kSecuredGroup))));
}

TEST(GroupGuard, LastNumbersOfSendersThatTheKeyringLacksForATimeAreKept) {
  GuardBench bench;
  bench.start();
  const wire::IndividualAddress third{0x110c};
  EXPECT_TRUE(opened(*bench.guard, indication(third, 9, value_for(kSecuredGroup))));
  auto fewer = one_group();
  fewer.groups[kSecuredGroup].senders.erase(third);
  bench.start(fewer);
  EXPECT_TRUE(opened(*bench.guard, indication(kOther, 9, value_for(kSecuredGroup))));
  bench.start();
  EXPECT_FALSE(opened(*bench.guard, indication(third, 9, value_for(kSecuredGroup))));
}

TEST(GroupGuard, StartValuesComeFromTheKeyring) {
  GuardBench bench;
  auto keys = one_group();
  keys.sequences = {{kOther, 281474976710000}, {kOwn, 281474976710100}};
  auto& guard = bench.start(keys);
  EXPECT_FALSE(opened(guard, indication(kOther, 281474976710000, value_for(kSecuredGroup))));
  EXPECT_TRUE(opened(guard, indication(kOther, 281474976710001, value_for(kSecuredGroup))));
  EXPECT_EQ(sequence_of(*guard.protect(CemiCode::kDataRequest, value_for(kSecuredGroup), kOwn)), 281474976710101U);
}

TEST(GroupGuard, ADiskThatFailsIsNotedAndTriedAgain) {
  GuardBench bench;
  bench.start();
  bench.disk.failure = "disk full";
  EXPECT_TRUE(opened(*bench.guard, indication(kOther, 9, value_for(kSecuredGroup))));
  bench.time.run_for(1s);
  ASSERT_THAT(bench.notes, SizeIs(1));
  EXPECT_THAT(bench.notes[0], HasSubstr("disk full"));
  const auto refused = bench.guard->protect(CemiCode::kDataRequest, value_for(kSecuredGroup), kOwn);
  EXPECT_THAT(refused.error().text, HasSubstr("disk full"));
  bench.disk.failure.clear();
  EXPECT_TRUE(bench.guard->protect(CemiCode::kDataRequest, value_for(kSecuredGroup), kOwn));
  EXPECT_TRUE(opened(*bench.guard, indication(kOther, 10, value_for(kSecuredGroup))));
  bench.start();
  EXPECT_FALSE(opened(*bench.guard, indication(kOther, 10, value_for(kSecuredGroup))));
}

TEST(GroupGuard, DamagedNumbersOfSendersAreNotedAndAnOwnOneStopsSending) {
  GuardBench bench;
  bench.disk.values["secure.senders-1.1"] = {1, 2, 3};
  bench.disk.values["secure.sequence"] = {1, 2, 3};
  auto& guard = bench.start();
  ASSERT_THAT(bench.notes, SizeIs(1));
  EXPECT_THAT(bench.notes[0], HasSubstr("secure.senders-1.1 are damaged"));
  EXPECT_THAT(guard.can_send().error().text, HasSubstr("cannot be read"));
  EXPECT_FALSE(guard.protect(CemiCode::kDataRequest, value_for(kSecuredGroup), kOwn));
}

}  // namespace
}  // namespace rubicon::networks::knx::secure
