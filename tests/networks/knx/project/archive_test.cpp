#include "networks/knx/project/archive.h"

#include <fmt/format.h>

#include "networks/knx/project/support.h"
#include "networks/knx/project/zip_source.h"
#include "support/memory/memory_transports.h"

namespace rubicon::networks::knx::project {
namespace {

using support::ZipEntry;
using support::ZipProtection;
using ::testing::HasSubstr;

constexpr std::string_view kEnd = "PK\x05\x06";

Result<std::string> content_of(const Archive& archive, const std::string& name,
                               const secure::Secret* password = nullptr) {
  const auto* entry = archive.find(name);
  if (entry == nullptr) return fail(ErrorCode::kNotFound, name);
  std::string content;
  auto read = archive.read(*entry, password, [&](std::string_view piece) -> Result<bool> {
    content += piece;
    return true;
  });
  if (!read) return fail(read.error());
  return content;
}

Error error_of_archive(std::string_view bytes, const ArchiveLimits& limits = {}) {
  const auto archive = Archive::open(file_with(bytes), limits);
  return archive ? Error{ErrorCode::kBusy, "it was opened"} : archive.error();
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (auto at = text.find(from); at != text.npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
  return text;
}

TEST(KnxArchive, EntriesComeBackInAnyProtection) {
  const std::string long_text(300'000, 'x');
  const auto password = secure::Secret::of_text("p\u00e4ss");
  for (const auto protection : {ZipProtection::kNone, ZipProtection::kZipCrypto, ZipProtection::kAes}) {
    const auto bytes =
        support::zip_of({{"a/b.xml", "short"}, {"c", long_text}, {"empty", ""}}, protection, "p\u00e4ss");
    ArchiveLimits limits;
    limits.ratio = 1000;
    const auto archive = Archive::open(file_with(bytes), limits);
    ASSERT_TRUE(archive) << archive.error().text;
    EXPECT_EQ(archive->entries().size(), 3U);
    for (const auto& [name, content] :
         {ZipEntry{"a/b.xml", "short"}, ZipEntry{"c", long_text}, ZipEntry{"empty", ""}}) {
      const auto read = content_of(*archive, name, &password);
      ASSERT_TRUE(read) << read.error().text;
      EXPECT_EQ(*read, content);
    }
    EXPECT_EQ(archive->find("b.xml"), nullptr);
  }
}

TEST(KnxArchive, AWrongOrMissingPasswordIsRefused) {
  const auto wrong = secure::Secret::of_text("wrong");
  for (const auto protection : {ZipProtection::kZipCrypto, ZipProtection::kAes}) {
    const auto archive = Archive::open(file_with(support::zip_of({{"a", "content"}}, protection, "right")));
    ASSERT_TRUE(archive);
    EXPECT_EQ(content_of(*archive, "a").error().code, ErrorCode::kRefused);
    EXPECT_THAT(content_of(*archive, "a").error().text, HasSubstr("'a' is protected by a password"));
    EXPECT_FALSE(content_of(*archive, "a", &wrong));
  }
}

TEST(KnxArchive, ReadingEndsWhenNoMoreIsNeeded) {
  ArchiveLimits limits;
  limits.ratio = 10'000;
  const auto archive = Archive::open(file_with(support::zip_of({{"a", std::string(10'000'000, 'x')}})), limits);
  ASSERT_TRUE(archive);
  int pieces = 0;
  EXPECT_TRUE(
      archive->read(*archive->find("a"), nullptr, [&](std::string_view) -> Result<bool> { return ++pieces < 2; }));
  EXPECT_EQ(pieces, 2);
  const auto failed = archive->read(*archive->find("a"), nullptr, [&](std::string_view) -> Result<bool> {
    return fail(ErrorCode::kDuplicate, "not this one");
  });
  EXPECT_EQ(failed.error().text, "not this one");
}

class Names : public ::testing::TestWithParam<const char*> {};

TEST_P(Names, ThatLeadOutOfTheFolderAreRefused) {
  const std::string name = GetParam();
  auto bytes = support::zip_of({{"knx_master.xml", "x"}, {std::string(name.size(), '~'), "x"}});
  bytes = replaced(bytes, std::string(name.size(), '~'), name);
  const auto error = error_of_archive(bytes);
  EXPECT_EQ(error.code, ErrorCode::kInvalid);
  EXPECT_THAT(error.text, HasSubstr("its entry 2 is named")) << error.text;
  EXPECT_THAT(error.text, HasSubstr("expected a relative path without '..'"));
}

INSTANTIATE_TEST_SUITE_P(All, Names,
                         ::testing::Values("../etc/passwd", "..", "a/../../b", "a/..", "a\\..\\b", "/etc/passwd",
                                           "\\\\host\\x", "C:\\x", "..\\x"));

TEST(KnxArchive, DotsWithinNamesAreNames) {
  EXPECT_EQ(error_of_archive(support::zip_of({{"a..b/c...", "x"}, {"...", "x"}})).code, ErrorCode::kBusy);
}

TEST(KnxArchive, ANameTwiceIsRefused) {
  const auto error = error_of_archive(replaced(support::zip_of({{"one.xml", "x"}, {"two.xml", "y"}}), "two", "one"));
  EXPECT_THAT(error.text, HasSubstr("has entry 'one.xml' twice"));
}

TEST(KnxArchive, MoreEntriesThanTheBoundAreRefusedBeforeTheyAreListed) {
  std::vector<ZipEntry> many;
  for (int i = 0; i < 101; ++i) many.push_back({fmt::format("e{}", i), "x"});
  ArchiveLimits limits;
  limits.entries = 100;
  const auto error = error_of_archive(support::zip_of(many), limits);
  EXPECT_EQ(error.code, ErrorCode::kOutOfRange);
  EXPECT_THAT(error.text, HasSubstr("has 101 entries, expected at most 100"));
  many.pop_back();
  EXPECT_EQ(error_of_archive(support::zip_of(many), limits).code, ErrorCode::kBusy);
}

TEST(KnxArchive, ClaimsOfTheEndAreCheckedBeforeMemoryIsTaken) {
  auto bytes = support::zip_of({{"a", "x"}});
  const auto end = bytes.rfind(kEnd);
  auto many = bytes;
  many.replace(end + 8, 4, number_text(60'000, 2) + number_text(60'000, 2));
  EXPECT_THAT(error_of_archive(many).text, HasSubstr("has 60000 entries, expected at most 10000"));
  auto large = bytes;
  large.replace(end + 12, 4, number_text(0x70000000, 4));
  EXPECT_THAT(error_of_archive(large).text, HasSubstr("its list of entries has 1879048192 bytes"));
  // The end of a large archive (zip64), with a locator before the end.
  auto zip64 = bytes.substr(0, end) + "PK\x06\x06" + number_text(44, 8) + number_text(45, 2) + number_text(45, 2) +
               number_text(0, 8) + number_text(5'000'000'000, 8) + number_text(5'000'000'000, 8) + number_text(60, 8) +
               number_text(0, 8) + "PK\x06\x07" + number_text(0, 4) + number_text(end, 8) + number_text(1, 4) +
               bytes.substr(end);
  EXPECT_THAT(error_of_archive(zip64).text, HasSubstr("has 5000000000 entries"));
}

TEST(KnxArchive, BombsAreRefused) {
  const auto bomb = support::zip_of({{"a", std::string(5'000'000, 'x')}});
  const auto archive = Archive::open(file_with(bomb));
  ASSERT_TRUE(archive) << "the entry is not needed yet";
  const auto error = content_of(*archive, "a").error();
  EXPECT_EQ(error.code, ErrorCode::kOutOfRange);
  EXPECT_THAT(error.text, HasSubstr("more than 300 times as much"));
  ArchiveLimits limits;
  limits.unpacked = 4'999'999;
  EXPECT_THAT(error_of_archive(bomb, limits).text, HasSubstr("unpacks to more than 4999999 bytes"));
  limits = {};
  limits.bytes = 100;
  EXPECT_THAT(error_of_archive(bomb, limits).text, HasSubstr("expected at most 100"));
}

TEST(KnxArchive, AnEntryCannotUnpackToMoreThanItsStatedSize) {
  auto bytes = support::zip_of({{"a", std::string(100'000, 'x')}});
  const auto directory = bytes.rfind("PK\x01\x02");
  bytes.replace(directory + 24, 4, number_text(1000, 4));
  const auto archive = Archive::open(file_with(bytes));
  ASSERT_TRUE(archive);
  EXPECT_FALSE(content_of(*archive, "a"));
}

TEST(KnxArchive, OtherCompressionsAreNamed) {
  auto bytes = support::zip_of({{"a", std::string(1000, 'x')}});
  bytes.replace(bytes.rfind("PK\x01\x02") + 10, 2, number_text(14, 2));  // LZMA
  const auto archive = Archive::open(file_with(bytes));
  ASSERT_TRUE(archive) << archive.error().text;
  EXPECT_THAT(content_of(*archive, "a").error().text, HasSubstr("has compression method 14, expected deflate"));
}

TEST(KnxArchive, ADamagedEntryIsNamed) {
  auto bytes = support::zip_of({{"one.xml", "0123456789abcdefghij0123456789"}, {"two.xml", "fine"}});
  bytes[45] = static_cast<char>(bytes[45] ^ 0x55);
  const auto archive = Archive::open(file_with(bytes));
  ASSERT_TRUE(archive);
  EXPECT_THAT(content_of(*archive, "one.xml").error().text, HasSubstr("entry 'one.xml' cannot be unpacked"));
  EXPECT_EQ(content_of(*archive, "two.xml").value(), "fine");
}

TEST(KnxArchive, WhatIsNoArchiveIsSaid) {
  EXPECT_THAT(error_of_archive("").text, HasSubstr("not a zip archive, or its end is missing"));
  EXPECT_THAT(error_of_archive("Group name;Address\n").text, HasSubstr("not a zip archive"));
  EXPECT_THAT(error_of_archive(std::string(kEnd) + std::string(10, '\0')).text, HasSubstr("not a zip archive"));
}

TEST(KnxArchive, AReadErrorOfTheFileIsAnError) {
  const auto bytes = support::zip_of({{"a", std::string(100'000, 'x')}, {"b", std::string(3000, 'y')}});
  transport::MemoryTransports files;
  for (std::uint64_t at = 0; at < bytes.size(); at += 7) {
    files.put("x.knxproj", bytes);
    files.fail_at("x.knxproj", at);
    const auto archive = Archive::open(files.open_file("x.knxproj").value());
    if (archive) static_cast<void>(content_of(*archive, "a"));
  }
}

TEST(KnxArchive, ArchivesWithinHaveABound) {
  const auto outer = support::zip_of({{"P-1.zip", support::zip_of({{"0.xml", "inner"}})}});
  const auto archive = Archive::open(file_with(outer));
  ASSERT_TRUE(archive);
  const auto inner = archive->open_inner(*archive->find("P-1.zip"));
  ASSERT_TRUE(inner) << inner.error().text;
  EXPECT_EQ(content_of(*inner, "0.xml").value(), "inner");
  ArchiveLimits limits;
  limits.inner_archive = 10;
  const auto small = Archive::open(file_with(outer), limits);
  EXPECT_THAT(small->open_inner(*small->find("P-1.zip")).error().text, HasSubstr("expected at most 10"));
}

}  // namespace
}  // namespace rubicon::networks::knx::project
