#include "networks/knx/secure/group_keys.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "networks/knx/secure/guard_bench.h"
#include "support/folder.h"
#include "transport/local_transports.h"

namespace rubicon::networks::knx::secure {
namespace {

using std::filesystem::perms;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

const std::string kDigits = "303132333435363738393a3b3c3d3e3f";

TEST(GroupKeysFile, HasOneGroupInALine) {
  const auto keys =
      parse_group_keys("# hall\n\n1/2/7 " + kDigits + "\r\n\t2/0/1\t303132333435363738393A3B3C3D3E3F  sender " +
                       "1.1.5  1.1.6 # two\n1/513 00000000000000000000000000000001");
  ASSERT_TRUE(keys) << keys.error().text;
  ASSERT_EQ(keys->groups.size(), 3U);
  const auto& open = keys->groups.at(wire::GroupAddress(0x0a07));
  EXPECT_EQ(*open.key, Key(counting(0x30, 16).view()));
  EXPECT_TRUE(open.any_sender && open.may_send_from(wire::IndividualAddress(0x1101)));
  EXPECT_THAT(open.senders, IsEmpty());
  const auto& narrow = keys->groups.at(wire::GroupAddress(0x1001));
  EXPECT_EQ(*narrow.key, *open.key);
  EXPECT_FALSE(narrow.any_sender);
  EXPECT_THAT(narrow.senders, ElementsAre(wire::IndividualAddress(0x1105), wire::IndividualAddress(0x1106)));
  EXPECT_TRUE(keys->groups.contains(wire::GroupAddress(0x0a01)));
}

struct WrongLine {
  std::string line, error;
};

class WrongGroupKeys : public ::testing::TestWithParam<WrongLine> {};

TEST_P(WrongGroupKeys, AreNamedByTheirLineWithoutAKey) {
  const auto keys = parse_group_keys("1/2/7 " + kDigits + "\n" + GetParam().line + "\n");
  ASSERT_FALSE(keys);
  EXPECT_EQ(keys.error().code, ErrorCode::kInvalid);
  EXPECT_THAT(keys.error().text, AllOf(HasSubstr("line 2: "), HasSubstr(GetParam().error), Not(HasSubstr("3031"))));
}

INSTANTIATE_TEST_SUITE_P(
    Lines, WrongGroupKeys,
    testing::Values(WrongLine{kDigits + " 1/2/8", "its first word is not a group address"},
                    WrongLine{"0/0/0 " + kDigits, "its first word is not a group address"},
                    WrongLine{"1/2/8", "not followed by a key of 32 hexadecimal digits"},
                    WrongLine{"1/2/8 " + kDigits + "40", "not followed by a key of 32 hexadecimal digits"},
                    WrongLine{"1/2/8 " + kDigits.substr(2), "not followed by a key of 32 hexadecimal digits"},
                    WrongLine{"1/2/8 " + kDigits.substr(1) + "x", "not followed by a key of 32 hexadecimal digits"},
                    WrongLine{"1/2/7 " + kDigits, "1/2/7 has a key in a line before"},
                    WrongLine{"1/2/8 " + kDigits + " " + kDigits, "something other than `sender`"},
                    WrongLine{"1/2/8 " + kDigits + " sender", "`sender` is not followed by an individual address"},
                    WrongLine{"1/2/8 " + kDigits + " sender 1.1.5 1.1.300", "not only individual addresses"},
                    WrongLine{"1/2/8 " + kDigits + " sender 0.0.0", "not only individual addresses"}));

TEST(GroupKeysFile, WithoutAKeyIsAnError) {
  for (const auto* text : {"", "\n", "# 1/2/7\n"})
    EXPECT_THAT(parse_group_keys(text).error().text, HasSubstr("has no key"));
}

TEST(GroupKeysFile, IsForItsOwnerOnly) {
  const support::Folder folder;
  transport::LocalTransports disk;
  const auto path = folder / "group.keys";
  std::ofstream(path) << "1/2/7 " << kDigits << "\n";
  std::filesystem::permissions(path, perms::owner_read | perms::owner_write);
  EXPECT_EQ(read_group_keys_file(disk, path)->groups.size(), 1U);
  std::filesystem::permissions(path, perms::others_read, std::filesystem::perm_options::add);
  const auto refused = read_group_keys_file(disk, path);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kRefused);
  EXPECT_THAT(refused.error().text, AllOf(HasSubstr("run chmod 600 " + path), Not(HasSubstr("3031"))));
  EXPECT_EQ(read_group_keys_file(disk, folder / "none").error().code, ErrorCode::kNotFound);
}

TEST(GroupKeysFile, IsNamedInErrorsAndBounded) {
  const support::Folder folder;
  transport::LocalTransports disk;
  const auto write = [&](const std::string& content) {
    std::ofstream(folder / "group.keys") << content;
    std::filesystem::permissions(folder / "group.keys", perms::owner_read | perms::owner_write);
    return read_group_keys_file(disk, folder / "group.keys").error().text;
  };
  EXPECT_THAT(write("1/2/7 00\n"), AllOf(HasSubstr("group.keys: line 1: "), HasSubstr("32 hexadecimal digits")));
  EXPECT_THAT(write(std::string(kMaxGroupKeysBytes + 1, '#')), HasSubstr("has more than 1048576 bytes"));
}

}  // namespace
}  // namespace rubicon::networks::knx::secure
