#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "base/virtual_scheduler.h"
#include "tuples/peis/capture.h"
#include "tuples/peis/connection.h"
#include "tuples/peis/fragments.h"
#include "tuples/peis/rewritten.h"

namespace rubicon::tuples::peis {
namespace {

/// Bytes that mean nothing: kernels fill them with old memory, or we cannot know what they were. All that is not
/// compared is in these lists.
struct Unused {
  std::size_t begin, end;  ///< up to, not including
  const char* what;
};
const std::vector<Unused> kInHost{{137, 144, "padding"}, {528, 536, "last seen, for the sender only"}};
const std::vector<Unused> kInTuple{{37, 40, "padding"}, {48, 76, "unused"}, {76, 84, "key depth and allocated length"}};
const std::vector<Unused> kInUnsubscribe{
    {32, 40, "encoding and media type, old memory"}, {48, 84, "unused"}, {212, 224, "isNew to appends, old memory"}};
const std::map<Port, std::vector<Unused>> kInBody{
    {Port::kRouting, {{6, 8, "padding"}}},
    {Port::kHostInfo, {{545, 552, "padding"}}},
    {Port::kTimeSync, {{9, 12, "padding"}}},
};
const Unused kInHeader{38, 40, "padding"};
constexpr std::size_t kKeyBegin = 84, kKeyEnd = 212;  // what follows the NUL of the key is unused too

void clear(Bytes& bytes, std::size_t base, const std::vector<Unused>& list) {
  for (const auto& unused : list)
    std::fill(bytes.begin() + static_cast<std::ptrdiff_t>(base + unused.begin),
              bytes.begin() + static_cast<std::ptrdiff_t>(base + unused.end), std::uint8_t{0});
}

void clear_addresses(Bytes& bytes, std::size_t base) {
  for (std::size_t i = 0; i < kMaxAddresses; ++i) clear(bytes, base + 144 + i * 24, {{9, 12, "padding"}});
}

void clear_key_tail(Bytes& bytes, std::size_t base) {
  const auto end = bytes.begin() + static_cast<std::ptrdiff_t>(base + kKeyEnd);
  std::fill(std::find(bytes.begin() + static_cast<std::ptrdiff_t>(base + kKeyBegin), end, 0), end, std::uint8_t{0});
}

Bytes meaning(Port port, ByteView body) {
  Bytes bytes(body.begin(), body.end());
  if (const auto list = kInBody.find(port); list != kInBody.end()) clear(bytes, 0, list->second);
  if (port == Port::kHostInfo) {
    clear(bytes, 0, kInHost);
    clear_addresses(bytes, 0);
  }
  const std::set<Port> tuples{Port::kSubscribe, Port::kUnsubscribe, Port::kPush,
                              Port::kSetRemote, Port::kSetAppend,   Port::kPushAppended};
  if (!tuples.contains(port)) return bytes;
  const std::size_t base = port == Port::kSubscribe ? 4 : 0;
  clear(bytes, base, port == Port::kUnsubscribe ? kInUnsubscribe : kInTuple);
  clear_key_tail(bytes, base);
  return bytes;
}

Bytes meaning_of_announcement(ByteView datagram) {
  Bytes bytes(datagram.begin(), datagram.end());
  clear(bytes, 0, {{4, 8, "padding"}});
  clear(bytes, 72, kInHost);
  clear_addresses(bytes, 72);
  return bytes;
}

using Counts = std::map<std::string, int>;

void check_body(Port port, ByteView body, Counts& counts) {
  ++counts[to_string(port)];
  const auto again = rewritten(port, body);
  ASSERT_TRUE(again) << to_string(port);
  ASSERT_TRUE(again->has_value()) << again->error().text;
  EXPECT_EQ(base::to_hex(meaning(port, **again)), base::to_hex(meaning(port, body))) << to_string(port);
  if (port == Port::kUnsubscribe) return;  // what is not said in it is written as open: not zero
  EXPECT_EQ(base::to_hex(**again), base::to_hex(meaning(port, **again))) << to_string(port) << ": not cleared";
}

void check_package(const Package& package, Fragments& fragments, Counts& counts) {
  Bytes again;
  append_package(again, package.header, package.body);
  EXPECT_EQ(read_package_header(again).value(), package.header);
  if (package.header.fragments == 0) return check_body(package.header.port, package.body, counts);
  ++counts["fragment"];
  const auto whole = fragments.add(package.header, package.body);
  ASSERT_TRUE(whole) << whole.error().text;
  if (*whole) check_body(package.header.port, **whole, counts);
}

/// The bytes of all packages, from which the stream is written again: only the padding of headers may differ.
Counts check_stream(const Stream& stream) {
  Counts counts;
  VirtualScheduler time;
  Fragments fragments(time);
  PackageStream packages;
  packages.append(stream.bytes);
  Bytes again, expected = stream.bytes;
  if (stream.of_initiator) {
    const auto connect = packages.connect();
    if (!connect || !*connect) return counts;
    ++counts["connect message"];
    again = write(**connect);
  }
  for (;;) {
    const auto package = packages.next();
    if (!package) ADD_FAILURE() << package.error().text;
    if (!package || !*package) break;
    clear(expected, again.size(), {kInHeader});
    append_package(again, (*package)->header, (*package)->body);
    check_package(**package, fragments, counts);
  }
  EXPECT_EQ(packages.pending(), 0U) << "bytes that are no package";
  EXPECT_EQ(base::to_hex(again), base::to_hex(expected));
  EXPECT_EQ(fragments.incomplete(), 0U);
  return counts;
}

TEST(PeisCaptures, EachAnnouncementIsReadAndWrittenByteForByte) {
  int checked = 0;
  for (const auto& name : capture_names()) {
    SCOPED_TRACE(name);
    for (const auto& datagram : read_capture(name).datagrams) {
      const auto announcement = read_announcement(datagram);
      ASSERT_TRUE(announcement) << announcement.error().text;
      EXPECT_EQ(announcement->network, "default");
      const auto again = write(*announcement);
      EXPECT_EQ(base::to_hex(again), base::to_hex(meaning_of_announcement(datagram)));
      ++checked;
    }
  }
  EXPECT_EQ(checked, 43);
}

TEST(PeisCaptures, EachPackageIsReadAndWrittenByteForByte) {
  Counts total;
  for (const auto& name : capture_names()) {
    SCOPED_TRACE(name);
    for (const auto& stream : read_capture(name).streams) {
      SCOPED_TRACE(stream.from);
      for (const auto& [what, count] : check_stream(stream)) total[what] += count;
    }
  }
  const Counts expected{{"connect message", 11}, {"ACKS", 101},          {"DEAD_HOST", 5},  {"HOSTINFO", 45},
                        {"PUSH_APPENDED", 3},    {"PUSH_TUPLE", 54 + 4}, {"QUERY_HOST", 2}, {"ROUTING", 55},
                        {"SET_APPEND", 1},       {"SET_REMOTE", 4 + 2},  {"SUBSCRIBE", 38}, {"TIMESYNC", 1},
                        {"UNSUBSCRIBE", 21},     {"fragment", 24}};  // of the 4 and 2 messages above that are long
  EXPECT_EQ(total, expected);
}

TEST(PeisCaptures, TheStreamsOfTwoKernelsHaveThePackagesOfTheirTable) {
  const auto capture = read_capture("peis-g6");
  EXPECT_EQ(capture.datagrams.size(), 17U);
  ASSERT_EQ(capture.streams.size(), 2U);
  const Counts to_owner{{"connect message", 1}, {"HOSTINFO", 2},   {"ROUTING", 2}, {"SUBSCRIBE", 2},
                        {"UNSUBSCRIBE", 1},     {"SET_REMOTE", 2}, {"ACKS", 6},    {"DEAD_HOST", 1}};
  EXPECT_EQ(check_stream(capture.streams[0]), to_owner);
  const Counts from_owner{{"HOSTINFO", 2}, {"ROUTING", 3},       {"PUSH_TUPLE", 6},
                          {"fragment", 4}, {"PUSH_APPENDED", 1}, {"ACKS", 5}};
  EXPECT_EQ(check_stream(capture.streams[1]), from_owner);
}

}  // namespace
}  // namespace rubicon::tuples::peis
