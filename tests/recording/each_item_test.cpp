#include "recording/recording_reader.h"

#include <gmock/gmock.h>

#include <algorithm>

#include "recordings.h"

namespace rubicon::recording {
namespace {

using testing::SizeIs;

/// Gives a file in pieces of 100 bytes.
class Pieces {
 public:
  explicit Pieces(Bytes file) : file_(std::move(file)) {}

  Result<std::size_t> read(std::span<std::uint8_t> into) {
    const auto count = std::min({into.size(), file_.size() - at_, std::size_t{100}});
    if (at_ >= fails_at) return fail(ErrorCode::kIo, "the disk is gone");
    std::copy_n(file_.begin() + static_cast<std::ptrdiff_t>(at_), count, into.begin());
    at_ += count;
    return count;
  }

  std::size_t fails_at = std::string::npos;

 private:
  Bytes file_;
  std::size_t at_ = 0;
};

/// The values of the records, until one is `last`.
Result<void> values_of(Pieces& pieces, std::vector<std::string>& values, const std::string& last = {}) {
  return each_item([&](std::span<std::uint8_t> into) { return pieces.read(into); },
                   [&](const RecordingReader::Item& item) -> Result<void> {
                     if (const auto* record = std::get_if<Record>(&item)) values.emplace_back(record->value);
                     if (!values.empty() && values.back() == last) return fail(ErrorCode::kRefused, "enough");
                     return {};
                   });
}

TEST(EachItem, VisitsAllInOrder) {
  Pieces pieces(file_of(three_blocks()));
  std::vector<std::string> values;
  ASSERT_TRUE(values_of(pieces, values));
  ASSERT_THAT(values, SizeIs(12));
  EXPECT_EQ(values.front(), "0.5");
  EXPECT_EQ(values.back(), "11.5");
}

TEST(EachItem, WhatIsCutAtTheEndIsDamage) {
  auto file = file_of(three_blocks());
  file.resize(file.size() - 1);
  Pieces pieces(std::move(file));
  std::size_t damaged = 0;
  ASSERT_TRUE(each_item([&](std::span<std::uint8_t> into) { return pieces.read(into); },
                        [&](const RecordingReader::Item& item) -> Result<void> {
                          damaged += std::holds_alternative<Damage>(item) ? 1U : 0U;
                          return {};
                        }));
  EXPECT_EQ(damaged, 1U);
}

TEST(EachItem, EndsWithTheFirstError) {
  Pieces pieces(file_of(three_blocks()));
  std::vector<std::string> values;
  EXPECT_EQ(values_of(pieces, values, "5.5").error().text, "enough");
  EXPECT_THAT(values, SizeIs(6));
  Pieces failing(file_of(three_blocks()));
  failing.fails_at = 100;
  values.clear();
  EXPECT_EQ(values_of(failing, values).error().code, ErrorCode::kIo);
  EXPECT_THAT(values, SizeIs(testing::Lt(12U)));
}

}  // namespace
}  // namespace rubicon::recording
