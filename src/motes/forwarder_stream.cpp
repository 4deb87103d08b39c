#include "motes/forwarder_stream.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/assert.h"

namespace rubicon::motes {

Result<void> ForwarderReader::greet(std::uint8_t byte) {
  if (greeting_ == 0 && byte != kForwarderHello[0])
    return fail(ErrorCode::kInvalid,
                fmt::format("not the serial-forwarder protocol: greeted with {:02x}, expected 55", byte));
  if (greeting_ == 1 && byte < kForwarderHello[1])
    return fail(ErrorCode::kInvalid,
                fmt::format("version {:02x} of the serial-forwarder protocol, expected 20 or newer", byte));
  ++greeting_;
  return {};
}

Result<std::optional<ByteView>> ForwarderReader::next(ByteView& bytes) {
  while (!bytes.empty() && !fault_) {
    if (wanted_ > 0) {
      const auto count = std::min(bytes.size(), wanted_ - size_);
      std::copy_n(bytes.begin(), count, buffer_.begin() + static_cast<std::ptrdiff_t>(size_));
      bytes = bytes.subspan(count);
      size_ += count;
      if (size_ < wanted_) break;
      return std::optional(ByteView(buffer_).first(std::exchange(wanted_, 0)));
    }
    const std::uint8_t byte = bytes.front();
    bytes = bytes.subspan(1);
    if (!greeted()) {
      if (auto valid = greet(byte); !valid) fault_ = valid.error();
    } else if (byte == 0) {
      fault_ = Error{ErrorCode::kInvalid, "a packet of 0 bytes in the serial-forwarder protocol, expected 1 to 255"};
    } else {
      wanted_ = byte;
      size_ = 0;
    }
  }
  if (fault_) return fail(*fault_);
  return std::optional<ByteView>();
}

Bytes forwarder_packet(ByteView packet) {
  RUBICON_ASSERT(!packet.empty() && packet.size() <= 255);
  Bytes out;
  out.reserve(packet.size() + 1);
  out.push_back(static_cast<std::uint8_t>(packet.size()));
  out.insert(out.end(), packet.begin(), packet.end());
  return out;
}

}  // namespace rubicon::motes
