#include "tuples/peis/own_messages.h"

#include <gtest/gtest.h>

namespace rubicon::tuples::peis {
namespace {

using namespace std::chrono_literals;

TEST(PeisOwnMessages, AReplyHasTheseBytes) {
  const Reply reply{OwnerId{7}, 0x0102, Verdict::kRefused, ErrorCode::kBusy, "no", 9};
  const auto bytes = write_reply(reply);
  EXPECT_EQ(base::to_hex(bytes),
            "5242433100000000000001020000000000000009"
            "0105"
            "6e6f");
  const auto read = *read_reply(bytes);
  EXPECT_EQ(read.request, reply.request);
  EXPECT_EQ(read.sequence, reply.sequence);
  EXPECT_EQ(read.verdict, reply.verdict);
  EXPECT_EQ(read.code, reply.code);
  EXPECT_EQ(read.text, reply.text);
}

TEST(PeisOwnMessages, ControlMessagesComeBack) {
  const auto end = *read_control(write_control(SnapshotEnd{77}));
  EXPECT_EQ(std::get<SnapshotEnd>(end).subscription, 77u);
  const auto restart = *read_control(write_control(Restart{WallTime(5us)}));
  EXPECT_EQ(std::get<Restart>(restart).since, WallTime(5us));
  EXPECT_TRUE(is_forget(write_forget()));
  EXPECT_FALSE(is_forget(write_control(SnapshotEnd{77})));
}

TEST(PeisOwnMessages, WhatIsNoneIsRefused) {
  const auto with = [](Bytes bytes, std::size_t at, std::uint8_t value) {
    bytes.at(at) = value;
    return bytes;
  };
  const auto reply = write_reply({});
  EXPECT_FALSE(read_reply(ByteView(reply).first(21)));
  EXPECT_FALSE(read_reply(with(reply, 0, 'X')));
  EXPECT_FALSE(read_reply(with(reply, 20, 4)));
  EXPECT_FALSE(read_reply(with(reply, 21, 10)));
  const auto end = write_control(SnapshotEnd{1});
  EXPECT_FALSE(read_control(ByteView(end).first(7)));
  EXPECT_FALSE(read_control(ByteView(end).first(11)));
  EXPECT_FALSE(read_control(with(end, 4, 4)));
  EXPECT_FALSE(is_forget(Bytes{}));
}

}  // namespace
}  // namespace rubicon::tuples::peis
