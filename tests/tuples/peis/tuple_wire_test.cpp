#include "tuples/peis/tuple_wire.h"

#include <gtest/gtest.h>

#include "tuples/peis/wire.h"

namespace rubicon::tuples::peis {
namespace {

using namespace std::chrono_literals;

// The hex texts are those of peis.md, sections 3.8 and 6.3; `..` there are zeros here.

std::string times(std::size_t count, std::string_view text) {
  std::string all;
  for (std::size_t i = 0; i < count; ++i) all += text;
  return all;
}

/// A tuple: the 48 bytes before the unused ones, those (28, depth and allocated length), the key, the 12 at the end.
Bytes tuple_bytes(std::string_view head, std::string_view key, std::string_view end, std::string_view behind = "",
                  std::string_view unused = "") {
  auto bytes = base::from_hex(head).value();
  EXPECT_EQ(bytes.size(), 48U);
  const auto between = base::from_hex(unused.empty() ? times(36, "00") : std::string(unused)).value();
  EXPECT_EQ(between.size(), 36U);
  bytes.insert(bytes.end(), between.begin(), between.end());
  bytes.insert(bytes.end(), key.begin(), key.end());
  bytes.resize(212);
  for (const auto text : {end, behind}) {
    const auto more = base::from_hex(text).value();
    bytes.insert(bytes.end(), more.begin(), more.end());
  }
  return bytes;
}

constexpr std::string_view kPushHead =
    "00000065 00000065 6b00dd01 00014e56 00000000 00000000 00000000 00000000 00000000 0a000000 01000000 00000005";
constexpr std::string_view kPlain = "74657874 2f706c61 696e";

const Bytes& push_bytes() {
  static const auto bytes =
      tuple_bytes(kPushHead, "demo.temp.value", "00000001 00000000 00000000", std::string(kPlain) + "3231 2e3500");
  return bytes;
}

NetworkTuple pushed() {
  NetworkTuple tuple;
  tuple.owner = tuple.creator = OwnerId{101};
  tuple.key = "demo.temp.value";
  tuple.write_time = WallTime(0x6b00dd01s + 0x14e56us);
  tuple.user_time = tuple.expire_time = WallTime{};
  tuple.encoding = Encoding::kAscii;
  tuple.media_type = "text/plain";
  tuple.data = std::string_view("21.5\0", 5);
  tuple.sequence = 0;
  return tuple;
}

Bytes with(Bytes bytes, std::size_t at, std::string_view replacement) {
  const auto patch = base::from_hex(replacement).value();
  std::copy(patch.begin(), patch.end(), bytes.begin() + static_cast<std::ptrdiff_t>(at));
  return bytes;
}
std::string push_error(std::size_t at, std::string_view replacement) {
  const auto bytes = with(push_bytes(), at, replacement);
  const auto tuple = read_push(bytes);
  return tuple ? "read" : tuple.error().text;
}

TEST(PeisTuples, APushHasTheBytesOfTheReference) {
  EXPECT_EQ(base::to_hex(write_push(pushed())), base::to_hex(push_bytes()));
  const auto tuple = read_push(push_bytes());
  ASSERT_TRUE(tuple) << tuple.error().text;
  EXPECT_EQ(*tuple, pushed());
}

TEST(PeisTuples, ARemoteSetHasTheDataFlagBigEndian) {
  auto tuple = pushed();
  tuple.key = "act.switch.command";
  tuple.creator = OwnerId{102};
  tuple.write_time = WallTime(0x6b00dd0cs + 0x17b7aus);
  tuple.data = std::string_view("1\0", 2);
  const std::string begin = "00000065 00000066 6b00dd0c 00017b7a" + times(5, "00000000");
  const auto end = "00000001 00000000 00000000", behind = "74657874 2f706c61 696e 3100";
  EXPECT_EQ(base::to_hex(write_set_remote(tuple)),
            base::to_hex(tuple_bytes(begin + "0a000000 00000001 00000002", tuple.key, end, behind)));
  const auto sent = tuple_bytes(begin + "0affffff 00000001 00000002", tuple.key, end, behind);
  EXPECT_EQ(read_set_remote(sent).value(), tuple);
}

TEST(PeisTuples, PaddingAndOldMemoryAreNotRead) {
  auto bytes = with(push_bytes(), 37, "ffffff");
  bytes = with(bytes, 48, times(36, "e7"));
  bytes = with(bytes, 84 + 16, times(112, "41"));  // behind the NUL of the key
  bytes = with(bytes, 212, "ffffffff");
  EXPECT_EQ(read_push(bytes).value(), pushed());
}

TEST(PeisTuples, ADeletedTupleExpiresInTheFirstSecondOf1970) {
  auto tuple = pushed();
  tuple.expire_time = kDeleteTime;
  tuple.data = std::string_view("\0", 1);
  const auto bytes = write_push(tuple);
  EXPECT_EQ(base::to_hex(ByteView(bytes).subspan(24, 8)), "0000000100000000");
  EXPECT_EQ(read_push(bytes).value(), tuple);
}

TEST(PeisTuples, TheAppendNumberIsTakenAsItComes) {
  EXPECT_EQ(read_push(with(push_bytes(), 220, "bcb4f650")).value().appends, 0xbcb4f650U);
}

TEST(PeisTuples, APushMustHaveAllThatAKernelWouldMiss) {
  EXPECT_EQ(push_error(0, "ffffffff"), "PUSH_TUPLE: no owner, which a tuple must have");
  EXPECT_EQ(push_error(4, "ffffffff"), "PUSH_TUPLE: no creator, which a tuple must have");
  EXPECT_EQ(push_error(8, "ffffffffffffffff"), "PUSH_TUPLE: no write time, which a push must have");
  EXPECT_EQ(push_error(16, "ffffffffffffffff"), "PUSH_TUPLE: no user time, which a tuple must have");
  EXPECT_EQ(push_error(24, "ffffffffffffffff"), "PUSH_TUPLE: no expire time, which a tuple must have");
  EXPECT_EQ(push_error(32, "ffffffff"), "PUSH_TUPLE: no encoding, which a tuple must have");
  EXPECT_EQ(push_error(36, "00"), "PUSH_TUPLE: no media type, which a tuple must have");
  EXPECT_EQ(push_error(36, "ff"), "PUSH_TUPLE: no media type, which a tuple must have");
  EXPECT_EQ(push_error(36, "0f"), "PUSH_TUPLE: no data, which a tuple must have");
  EXPECT_EQ(push_error(40, "00000000"), "PUSH_TUPLE: no data, which a tuple must have");
  EXPECT_EQ(push_error(84, "00"), "PUSH_TUPLE: no key, which a tuple must have");
  EXPECT_EQ(push_error(84, "2a"), "PUSH_TUPLE: key with wildcards, expected none");
  EXPECT_EQ(push_error(216, "ffffffff"), "PUSH_TUPLE: no sequence, which a push must have");
}

TEST(PeisTuples, ErrorsNameTheFieldAndWhatWasExpected) {
  EXPECT_EQ(push_error(0, "80000000"), "PUSH_TUPLE: owner at 0: 80000000, expected 0 to 7fffffff or ffffffff");
  EXPECT_EQ(push_error(4, "fffffffe"), "PUSH_TUPLE: creator at 4: fffffffe, expected 0 to 7fffffff or ffffffff");
  EXPECT_EQ(push_error(16, "fffffffe"), "PUSH_TUPLE: user time at 16: fffffffe 00000000, expected no negative numbers");
  EXPECT_EQ(push_error(32, "00000002"), "PUSH_TUPLE: encoding at 32: 00000002, expected 0, 1 or ffffffff");
  EXPECT_EQ(push_error(36, "10"), "PUSH_TUPLE: media type of 16 bytes (at 36), but 15 bytes follow the tuple");
  EXPECT_EQ(push_error(84, times(128, "61")), "PUSH_TUPLE: key at 84: 128 bytes without NUL, expected one");
  EXPECT_EQ(read_push(ByteView(push_bytes()).first(223)).error().text, "PUSH_TUPLE: 223 bytes, a tuple has 224");
}

TEST(PeisTuples, ARemoteSetWithoutDataIsRefused) {
  auto bytes = write_set_remote(pushed());
  EXPECT_EQ(read_set_remote(with(bytes, 40, "00000000")).error().text, "SET_REMOTE: no data, which a tuple must have");
  bytes.resize(234);
  EXPECT_EQ(read_set_remote(bytes).error().text, "SET_REMOTE: no data, which a tuple must have");
}

TEST(PeisTuples, TheLongestKeyAndMediaTypeFit) {
  auto tuple = pushed();
  const std::string key(kMaxPeisKey, 'k'), media_type(kMaxMediaType, 'm');
  tuple.key = key;
  tuple.media_type = media_type;
  const auto bytes = write_push(tuple);
  EXPECT_EQ(read_push(bytes).value(), tuple);
}

TEST(PeisTuples, TimesAreLimitedToWhatTheWireCanSay) {
  auto tuple = pushed();
  tuple.user_time = WallTime(-5s);
  tuple.expire_time = WallTime(std::chrono::hours(24 * 365 * 100));
  const auto bytes = write_push(tuple);
  const auto read = read_push(bytes).value();
  EXPECT_EQ(read.user_time, WallTime{});
  EXPECT_EQ(read.expire_time, WallTime(0x7fffffffs + 999999us));
}

TEST(PeisTuples, MoreMicrosecondsThanASecondAreCarriedOver) {
  const auto at = [](std::string_view text) { return *read_push(with(push_bytes(), 16, text)).value().user_time; };
  EXPECT_EQ(at("00000005 001e8481"), WallTime(7s + 1us));
  EXPECT_EQ(at("7fffffff 7fffffff"), WallTime(0x7fffffffs + 999999us));
}

TEST(PeisTuples, ASubscriptionLeavesAllOpenButOwnerAndKey) {
  Subscribe subscribe;
  subscribe.prototype.owner = OwnerId{101};
  subscribe.prototype.key = "demo.temp.value";
  const auto bytes = write(subscribe);
  auto expected = tuple_bytes("00000065" + times(8, "ffffffff") + "00000000 00000000 00000000", "demo.temp.value",
                              "ffffffff ffffffff 00000000");
  expected.insert(expected.begin(), {1, 0, 0, 0});  // little-endian
  EXPECT_EQ(base::to_hex(bytes), base::to_hex(expected));
  EXPECT_EQ(read_subscribe(bytes).value(), subscribe);
}

TEST(PeisTuples, ASubscriptionMayHaveAMediaTypeAndData) {
  Subscribe subscribe{false, {}};
  subscribe.prototype.key = "demo.*.value";
  subscribe.prototype.media_type = "text/plain";
  subscribe.prototype.data = "21.5";
  const auto bytes = write(subscribe);
  EXPECT_EQ(base::to_hex(ByteView(bytes).subspan(4 + 36, 12)), "0a0000000000000100000004");
  EXPECT_EQ(read_subscribe(bytes).value(), subscribe);
}

TEST(PeisTuples, ErrorsOfASubscriptionNameTheFieldAndWhatWasExpected) {
  Subscribe subscribe;
  subscribe.prototype.key = "a";
  const auto bytes = write(subscribe);
  const auto error = [&](std::size_t at, std::string_view text) {
    return read_subscribe(with(bytes, 4 + at, text)).error().text;
  };
  EXPECT_EQ(error(36, "01"), "SUBSCRIBE: media type of 1 bytes (at 36), but 0 bytes follow the tuple");
  EXPECT_EQ(error(44, "00000001"), "SUBSCRIBE: data length at 44: 1, expected 0 without data");
  EXPECT_EQ(error(40, "00000001ffffffff"), "SUBSCRIBE: data of 4294967295 bytes (at 44), but 0 bytes follow");
  EXPECT_EQ(read_subscribe(ByteView(bytes).first(3)).error().text, "SUBSCRIBE: 3 bytes, expected at least 4");
  auto longer = bytes;
  longer.push_back(0);
  EXPECT_EQ(read_subscribe(longer).error().text, "SUBSCRIBE: 1 bytes behind the end, expected none");
}

/// The message of a kernel, with its old memory.
Bytes unsubscribe_bytes() {
  return tuple_bytes("000000c8" + times(7, "ffffffff") + "31303120 2d312e20 00000000 00000000", "demo.*.value",
                     "00000000 ffffffff ffffffff", "",
                     "31202d31 2e64656d 6f2e7465 6d702e76 616c7565 20290a29 0a006572 00000000 00000000");
}

TEST(PeisTuples, TheBrokenUnsubscribeOfAKernelSaysOwnerAndKey) {
  const auto bytes = unsubscribe_bytes();
  const auto read = read_unsubscribe(bytes);
  ASSERT_TRUE(read) << read.error().text;
  EXPECT_EQ(*read, (Unsubscribe{OwnerId{200}, "demo.*.value", std::nullopt, {}}));
}

TEST(PeisTuples, TheDataOfAnUnsubscribeFollowsTheTupleWhateverTheMediaTypeSays) {
  auto bytes = with(unsubscribe_bytes(), 40, "00000001 00000003");
  for (const auto letter : {'o', 'n', '\0'}) bytes.push_back(static_cast<std::uint8_t>(letter));
  EXPECT_EQ(read_unsubscribe(bytes).value().data, std::string_view("on\0", 3));
  EXPECT_EQ(read_unsubscribe(write(read_unsubscribe(bytes).value())).value(), read_unsubscribe(bytes).value());
  bytes.push_back(0);
  EXPECT_EQ(read_unsubscribe(bytes).error().text, "UNSUBSCRIBE: 1 bytes behind the end, expected none");
}

TEST(PeisTuples, AnUnsubscribeOfOursIsClean) {
  const auto bytes = write(Unsubscribe{std::nullopt, "", std::nullopt, {}});
  EXPECT_EQ(base::to_hex(bytes),
            base::to_hex(tuple_bytes(times(9, "ffffffff") + times(3, "00000000"), "", "ffffffff ffffffff 00000000")));
}

TEST(PeisTuples, AnAppendedPushHasTheBytesOfTheReference) {
  const auto bytes = tuple_bytes(kPushHead, "demo.temp.value", "00000001 00000001 00000000", "00000006 3b32322e 3500");
  const auto appended = read_push_appended(bytes);
  ASSERT_TRUE(appended) << appended.error().text;
  EXPECT_EQ(appended->difference, std::string_view(";22.5\0", 6));
  EXPECT_EQ(appended->data_length, 5U);
  EXPECT_EQ(appended->tuple.sequence, 1U);
  EXPECT_EQ(base::to_hex(write(*appended)), base::to_hex(bytes));
}

TEST(PeisTuples, ErrorsOfAnAppendNameTheFieldAndWhatWasExpected) {
  const auto error = [](std::string_view behind) {
    return read_push_appended(tuple_bytes(kPushHead, "a", "00000001 00000001 00000000", behind)).error().text;
  };
  EXPECT_EQ(error("000000"), "PUSH_APPENDED: 227 bytes, tuple and length of the difference have 228");
  EXPECT_EQ(error("00000002 3b"), "PUSH_APPENDED: difference of 2 bytes (at 224), but 1 bytes follow");
  EXPECT_EQ(error("ffffffff"), "PUSH_APPENDED: difference of 4294967295 bytes (at 224), but 0 bytes follow");
}

TEST(PeisTuples, AnAppendByPrototypeHasTheDataOfThePrototypeFirst) {
  SetAppend append;
  append.prototype.owner = OwnerId{101};
  append.prototype.key = "fw.x";
  append.prototype.data = "before";
  append.difference = ";after";
  const auto bytes = write(append);
  EXPECT_EQ(base::as_text(ByteView(bytes).subspan(224)), std::string_view("\0\0\0\6before;after", 16));
  EXPECT_EQ(read_set_append(bytes).value(), append);
  append.prototype.data.reset();
  const auto open = write(append);
  EXPECT_EQ(open.size(), 224U + 4 + 6);
  EXPECT_EQ(read_set_append(open).value(), append);
  EXPECT_EQ(read_set_append(with(open, 44, "00000002")).error().text,
            "SET_APPEND: data length at 44: 2, expected 0 without data");
}

TEST(PeisTuples, TheAnnexIsKeptOnlyWithOurMark) {
  auto tuple = pushed();
  tuple.annex.fill(7);
  std::copy(kAnnexMark.begin(), kAnnexMark.end(), tuple.annex.begin());
  auto bytes = write_push(tuple);
  EXPECT_EQ(read_push(bytes).value().annex, tuple.annex);
  bytes[48] = 'r';
  EXPECT_EQ(read_push(bytes).value().annex, Annex{});
}

}  // namespace
}  // namespace rubicon::tuples::peis
