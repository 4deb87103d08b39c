#include <gtest/gtest.h>

#include <cmath>

#include "networks/knx/dpt/convert_line.h"
#include "networks/knx/dpt/samples.h"

// Compares with the payloads of two other libraries (knx.md 9.2).

namespace rubicon::networks::knx::dpt {
namespace {

double number_of(const Value& value) {
  const auto* whole = std::get_if<std::int64_t>(&value);
  return whole ? static_cast<double>(*whole) : std::get<double>(value);
}

TEST(DptVectors, EncodeAsOneOfTheTwoLibraries) {
  const auto rows = rows_of(shared_file("dpt-vectors.tsv"));
  if (rows.empty()) GTEST_SKIP() << "no " << shared_file("dpt-vectors.tsv");
  EXPECT_EQ(rows.size(), 2165U);
  for (const auto& row : rows) {
    const auto& type = dpt(row[0]);
    const auto sent = encode_text(type, row[1]);
    const auto hex = sent ? base::to_hex(sent->bytes) : std::string("reject");
    EXPECT_TRUE(hex == row[2] || hex == row[3])
        << row[0] << ' ' << row[1] << ": " << hex << ", not " << row[2] << " or " << row[3];
    const auto line = encode_line(row[0] + ' ' + row[1]);
    EXPECT_EQ(line.starts_with("error: ") ? "reject" : line, hex) << row[0] << ' ' << row[1];
  }
}

TEST(DptVectors, DecodeAsCalimeroDoes) {
  const auto rows = rows_of(shared_file("dpt-vectors.tsv"));
  if (rows.empty()) GTEST_SKIP() << "no " << shared_file("dpt-vectors.tsv");
  for (const auto& row : rows) {
    const auto& type = dpt(row[0]);
    const double expected = std::stod(row[5]);
    const auto value = decode(type, payload(type, row[2]));
    if (!value) {
      // Values that xknx sends and the table does not permit.
      EXPECT_EQ(row[3], "reject") << row[0] << ' ' << row[2] << ": " << value.error().text;
      continue;
    }
    const double off = 1e-6 * std::max(1e-9, std::abs(expected));
    EXPECT_NEAR(number_of(*value), expected, off) << row[0] << ' ' << row[2];
    EXPECT_NEAR(std::stod(decode_line(row[0] + ' ' + row[2])), expected, off) << row[0] << ' ' << row[2];
  }
}

}  // namespace
}  // namespace rubicon::networks::knx::dpt
