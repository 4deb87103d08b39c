#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "rubicon/result.hpp"

namespace rubicon::networks::zigbee::bridge {

/// Cuts a list of records into the texts of the records, without reading them. Checks brackets and UTF-8 of the list,
/// but not the content of a record.
class ListSlices {
 public:
  /// Bytes that are read behind a list: reserve them in it, and it is not copied.
  static constexpr std::size_t kPadding = 64;

  explicit ListSlices(std::string list);
  ~ListSlices();

  /// Looks through the whole list in one turn: 1.1 MB in half a millisecond, so 16 MB (the default `largest-packet`)
  /// take about 8 ms. kInvalid if it is no JSON array.
  Result<void> open();
  /// The next record; an empty text for an item that is no object; nullopt at the end. Valid as long as this lives.
  /// kInvalid if the list cannot be read from here on. Only after open().
  Result<std::optional<std::string_view>> next();
  /// Ends the slices and gives the list back.
  std::string take_text();

 private:
  struct Parsed;

  std::string list_;
  std::unique_ptr<Parsed> parsed_;
};

/// The address of a record that cannot be read otherwise; empty if it has none.
std::string address_in(std::string_view record);

}  // namespace rubicon::networks::zigbee::bridge
