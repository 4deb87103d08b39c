#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include "networks/knx/groups/csv_records.h"
#include "networks/knx/wire/address.h"

namespace rubicon::networks::knx::groups {

/// Which column of an ETS CSV export holds what.
struct CsvLayout {
  bool header = false;
  std::size_t names = 1;          ///< columns of names from 0: 1 = one; 2 = main, sub; 3 = main, middle, sub
  std::size_t address = 0;        ///< the first column of the address
  std::size_t address_parts = 1;  ///< in so many columns
  std::optional<std::size_t> central{}, unfiltered{}, description{}, comment{}, type{}, security{};
  wire::Notation notation = wire::Notation::kThreeLevel;

  /// `3/1`: names in three columns, addresses in one.
  std::string form() const;
};

/// The layout by the words of the header (any language ETS knows: by the content below it) and by what stands in the
/// first rows; nothing if no column holds addresses. The rows are decoded to UTF-8 or ASCII in what matters here.
std::optional<CsvLayout> find_layout(std::span<const CsvRecord> first_rows);

/// The address of a row as one text: `1/0/7`, `1/0/-`; parts that are absent become `-`.
std::string address_text(const CsvRecord& row, const CsvLayout& layout);

}  // namespace rubicon::networks::knx::groups
