#pragma once

#include <string>
#include <string_view>

#include "rubicon/result.hpp"

namespace rubicon::networks::dummy {

/// The addresses that one key of `simulate` stands for: `kitchen` for itself, `room-{1..10000}` for `room-1` to
/// `room-10000`, `{01..12}` with as many digits as its ends have.
class DeviceRange {
 public:
  /// kInvalid for two ranges in one key, ends that are no whole numbers, and a first one above the last.
  static Result<DeviceRange> parse(std::string_view key);

  std::size_t count() const { return last_ - first_ + 1; }
  std::string address(std::size_t index) const { return before_ + (is_range_ ? number(index) : "") + behind_; }
  /// `text` with the number of that device for `{n}`.
  std::string name(const std::string& text, std::size_t index) const;

 private:
  std::string number(std::size_t index) const;

  std::string before_, behind_;
  std::size_t first_ = 0, last_ = 0, digits_ = 0;  ///< digits: at least so many
  bool is_range_ = false;
};

}  // namespace rubicon::networks::dummy
