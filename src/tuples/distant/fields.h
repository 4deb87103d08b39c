#pragma once

#include <cstdint>
#include <string_view>
#include <utility>

#include "base/bytes.h"
#include "rubicon/address.hpp"
#include "rubicon/time.hpp"

namespace rubicon::tuples::distant {

/// Appends fields of what is sent to other components: numbers in groups of seven bits, the lowest first, each group
/// but the last with its highest bit set; signed numbers with their sign in the lowest bit; texts after their size.
class FieldWriter {
 public:
  void byte(std::uint8_t value) { bytes_.push_back(value); }
  void number(std::uint64_t value) { value < 0x80 ? byte(static_cast<std::uint8_t>(value)) : long_number(value); }
  void signed_number(std::int64_t value);
  void text(std::string_view text);
  void bytes(ByteView bytes) { bytes_.insert(bytes_.end(), bytes.begin(), bytes.end()); }

  std::size_t size() const { return bytes_.size(); }
  ByteView view() const { return bytes_; }
  Bytes take() { return std::exchange(bytes_, {}); }
  void clear() { bytes_.clear(); }

 private:
  void long_number(std::uint64_t value);

  Bytes bytes_;
};

/// Reads what FieldWriter wrote. After an invalid read all further ones give zero, ok() is false and at_end() true.
class FieldReader {
 public:
  explicit FieldReader(ByteView bytes) : bytes_(bytes) {}

  std::uint8_t byte() { return at_ < bytes_.size() ? bytes_[at_++] : fail_read(); }
  std::uint64_t number() { return at_ < bytes_.size() && bytes_[at_] < 0x80 ? bytes_[at_++] : long_number(); }
  std::int64_t signed_number();
  std::string_view text();
  /// All that follows.
  ByteView rest();
  WallTime time() { return WallTime(std::chrono::microseconds(signed_number())); }
  /// Clamped to 0..100 years.
  Duration duration();
  OwnerId owner();

  bool ok() const { return ok_; }
  bool at_end() const { return at_ == bytes_.size(); }
  std::size_t position() const { return at_; }
  /// The read was invalid, for a reason that the caller knows.
  std::uint8_t fail_read();

 private:
  std::uint64_t long_number();

  ByteView bytes_;
  std::size_t at_ = 0;
  bool ok_ = true;
};

}  // namespace rubicon::tuples::distant
