#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include "networks/knx/groups/csv_records.h"
#include "networks/knx/wire/address.h"

namespace rubicon::networks::knx::groups {

/// The columns of an ETS CSV export.
struct CsvLayout {
  bool header = false;
  std::size_t names = 1;          ///< number of name columns, the first ones: 1; 2 = main, sub; 3 = main, middle, sub
  std::size_t address = 0;        ///< the first column of the address
  std::size_t address_parts = 1;  ///< number of columns of the address
  std::optional<std::size_t> central{}, unfiltered{}, description{}, comment{}, type{}, security{};
  wire::Notation notation = wire::Notation::kThreeLevel;

  /// `3/1`: names in three columns, addresses in one.
  std::string form() const;
};

/// Finds the layout by the words of the header and by the content of the first rows, which also works for headers in
/// other languages; nullopt if no column holds addresses. The rows need not be decoded.
std::optional<CsvLayout> find_layout(std::span<const CsvRecord> first_rows);

/// The address of a row as one text: `1/0/7`, `1/0/-`; missing parts become `-`.
std::string address_text(const CsvRecord& row, const CsvLayout& layout);

}  // namespace rubicon::networks::knx::groups
