#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rubicon/result.hpp"

namespace rubicon::base {

using Bytes = std::vector<std::uint8_t>;
using ByteView = std::span<const std::uint8_t>;

/// What an empty buffer may keep, so that the usual one is not allocated each time.
inline constexpr std::size_t kKeptBuffer = 4UL * 1024;

/// Removes the first `count` bytes; the buffer has at least so many. If it is empty then and had grown, it gives its
/// memory back.
inline void drop_front(Bytes& bytes, std::size_t count) {
  bytes.erase(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(count));
  if (bytes.empty() && bytes.capacity() > kKeptBuffer) Bytes().swap(bytes);
}

/// Reads integers from a byte string, never beyond its end. After a read beyond the end all further ones give zero and
/// ok() is false: parse a whole record, then check once.
class ByteReader {
 public:
  explicit ByteReader(ByteView bytes) : bytes_(bytes) {}

  std::uint8_t u8();
  std::uint16_t u16_be();
  std::uint32_t u32_be();
  std::uint64_t u64_be();
  std::uint16_t u16_le();
  std::uint32_t u32_le();
  ByteView take(std::size_t count);
  void skip(std::size_t count) { take(count); }

  std::size_t position() const { return position_; }
  std::size_t remaining() const { return bytes_.size() - position_; }
  bool ok() const { return ok_; }

 private:
  ByteView bytes_;
  std::size_t position_ = 0;
  bool ok_ = true;
};

/// Appends integers to a byte string it owns.
class ByteWriter {
 public:
  ByteWriter& u8(std::uint8_t value);
  ByteWriter& u16_be(std::uint16_t value);
  ByteWriter& u32_be(std::uint32_t value);
  ByteWriter& u64_be(std::uint64_t value);
  ByteWriter& u16_le(std::uint16_t value);
  ByteWriter& u32_le(std::uint32_t value);
  ByteWriter& bytes(ByteView value);

  const Bytes& view() const { return bytes_; }
  Bytes take() { return std::move(bytes_); }

 private:
  Bytes bytes_;
};

/// Lower-case hex without separators.
std::string to_hex(ByteView bytes);
/// Accepts upper and lower case and blanks between bytes; kInvalid names the offending position.
Result<Bytes> from_hex(std::string_view text);

inline ByteView as_bytes(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}
inline std::string_view as_text(ByteView bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace rubicon::base

namespace rubicon {

using base::Bytes;
using base::ByteView;

}  // namespace rubicon

namespace rubicon::base {

/// Receives bytes in order: a file opened for appending, a vector in tests.
class ByteSink {
 public:
  virtual ~ByteSink() = default;
  /// Appends all bytes. After an error a part of them may have been appended.
  virtual Result<void> append(ByteView bytes) = 0;
};

/// Base 64 with padding, on one line (RFC 4648, section 4).
std::string to_base64(std::string_view bytes);
/// kInvalid names the position of the first character that is wrong; padding is required, blanks are not allowed.
Result<std::string> from_base64(std::string_view text);

}  // namespace rubicon::base
