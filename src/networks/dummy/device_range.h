#pragma once

#include <string>
#include <string_view>

#include "rubicon/result.hpp"

namespace rubicon::networks::dummy {

/// The addresses that a key of `simulate` names: `kitchen` one, `room-{1..10000}` those from `room-1` to `room-10000`.
/// Numbers have at least as many digits as the first one if that begins with 0: `{01..12}`.
class DeviceRange {
 public:
  /// kInvalid for two ranges in one key, ends that are not whole numbers, or a first number above the last.
  static Result<DeviceRange> parse(std::string_view key);

  std::size_t count() const { return last_ - first_ + 1; }
  std::string address(std::size_t index) const { return before_ + (is_range_ ? number(index) : "") + after_; }
  /// `text` with `{n}` replaced by the number of that device.
  std::string name(const std::string& text, std::size_t index) const;

 private:
  std::string number(std::size_t index) const;

  std::string before_, after_;
  std::size_t first_ = 0, last_ = 0, digits_ = 0;  ///< digits: the minimum
  bool is_range_ = false;
};

}  // namespace rubicon::networks::dummy
