#pragma once

#include <simdjson.h>

#include <optional>
#include <string>
#include <string_view>

#include "rubicon/result.hpp"

namespace rubicon::networks::zigbee::bridge {

/// Cuts a list of records into the texts of the records, without reading them. Checks brackets and UTF-8 of the list,
/// but not what is inside of a record.
class ListSlices {
 public:
  explicit ListSlices(std::string list);
  ListSlices(const ListSlices&) = delete;
  ListSlices& operator=(const ListSlices&) = delete;

  /// Looks through the whole list: 1.1 MB in half a millisecond. kInvalid if it is no JSON array.
  Result<void> open();
  /// The next record; an empty text for an item that is no object; nullopt at the end. Valid as long as this lives.
  /// kInvalid if the list cannot be read from here on. Only after open().
  Result<std::optional<std::string_view>> next();

 private:
  std::string list_;
  simdjson::ondemand::parser parser_;
  simdjson::ondemand::document document_;
  simdjson::ondemand::array_iterator at_, end_;
};

/// The address of a record that cannot be read otherwise; empty if it has none.
std::string address_in(std::string_view record);

}  // namespace rubicon::networks::zigbee::bridge
