#include "motes/framing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "base/assert.h"

namespace rubicon::motes {

namespace {

constexpr std::uint8_t kFlag = 0x7e;
constexpr std::uint8_t kEscape = 0x7d;
constexpr std::uint8_t kEscapeBit = 0x20;  ///< inverted in escaped bytes
constexpr std::uint8_t kUnknownProtocol = 0xff;
/// Protocol, sequence number or one byte, CRC.
constexpr std::size_t kMinFrame = 4;
constexpr std::size_t kCrcBytes = 2;

constexpr std::size_t kSlices = 8;
using CrcTables = std::array<std::array<std::uint16_t, 256>, kSlices>;

/// tables[k][b]: the CRC of the byte b followed by k zero bytes.
constexpr CrcTables make_tables() {
  CrcTables tables{};
  for (unsigned byte = 0; byte < 256; ++byte) {
    unsigned crc = byte << 8U;
    for (int bit = 0; bit < 8; ++bit) crc = ((crc << 1U) ^ ((crc & 0x8000U) != 0 ? 0x1021U : 0U)) & 0xffffU;
    tables[0][byte] = static_cast<std::uint16_t>(crc);
  }
  for (std::size_t k = 1; k < kSlices; ++k) {
    for (std::size_t byte = 0; byte < 256; ++byte) {
      const unsigned before = tables[k - 1][byte];
      tables[k][byte] = static_cast<std::uint16_t>(((before << 8U) ^ tables[0][before >> 8U]) & 0xffffU);
    }
  }
  return tables;
}

constexpr CrcTables kTables = make_tables();

/// Whether any of eight bytes is `wanted`.
constexpr bool any_is(std::uint64_t eight, std::uint8_t wanted) {
  constexpr std::uint64_t kOnes = 0x0101010101010101U, kTops = kOnes << 7U;
  const std::uint64_t zero_where_wanted = eight ^ (kOnes * wanted);
  return ((zero_where_wanted - kOnes) & ~zero_where_wanted & kTops) != 0;
}

/// How many bytes at the front are neither flag nor escape.
std::size_t plain_bytes(ByteView bytes) {
  std::size_t run = 0;
  for (; run + sizeof(std::uint64_t) <= bytes.size(); run += sizeof(std::uint64_t)) {
    std::uint64_t eight = 0;
    std::memcpy(&eight, bytes.data() + run, sizeof eight);
    if (any_is(eight, kFlag) || any_is(eight, kEscape)) break;
  }
  while (run < bytes.size() && bytes[run] != kFlag && bytes[run] != kEscape) ++run;
  return run;
}

void put(Bytes& out, std::uint8_t byte) {
  if (byte == kFlag || byte == kEscape) {
    out.push_back(kEscape);
    byte ^= kEscapeBit;
  }
  out.push_back(byte);
}

Bytes frame_of(ByteView head, ByteView packet) {
  const std::uint16_t crc = crc16(packet, crc16(head));
  Bytes out;
  out.reserve(head.size() + packet.size() + 8);
  out.push_back(kFlag);
  for (const std::uint8_t byte : head) put(out, byte);
  for (const std::uint8_t byte : packet) put(out, byte);
  put(out, static_cast<std::uint8_t>(crc & 0xffU));
  put(out, static_cast<std::uint8_t>(crc >> 8U));
  out.push_back(kFlag);
  return out;
}

}  // namespace

std::uint16_t crc16(ByteView bytes, std::uint16_t crc) {
  unsigned value = crc;
  const std::uint8_t* at = bytes.data();
  std::size_t left = bytes.size();
  for (; left >= kSlices; left -= kSlices, at += kSlices) {
    value = kTables[7][at[0] ^ (value >> 8U)] ^ kTables[6][at[1] ^ (value & 0xffU)] ^ kTables[5][at[2]] ^
            kTables[4][at[3]] ^ kTables[3][at[4]] ^ kTables[2][at[5]] ^ kTables[1][at[6]] ^ kTables[0][at[7]];
  }
  for (; left > 0; --left, ++at) value = ((value << 8U) & 0xffffU) ^ kTables[0][(value >> 8U) ^ *at];
  return static_cast<std::uint16_t>(value);
}

void HdlcReader::reset() {
  state_ = State::kHunting;
  size_ = 0;
}

std::optional<HdlcFrame> HdlcReader::next(ByteView& bytes) {
  while (!bytes.empty()) {
    if (state_ == State::kInside) bytes = take_plain_bytes(bytes);
    if (bytes.empty()) break;
    const std::uint8_t byte = bytes.front();
    bytes = bytes.subspan(1);
    if (byte != kFlag) {
      take(byte);
    } else if (auto frame = take_flag()) {
      return frame;
    }
  }
  return std::nullopt;
}

/// Copies the bytes up to the next flag or escape at once; returns the rest.
ByteView HdlcReader::take_plain_bytes(ByteView bytes) {
  const std::size_t most = std::min(bytes.size(), kMaxFrame - size_);
  const std::size_t run = plain_bytes(bytes.first(most));
  if (run > 0) std::memcpy(buffer_.data() + size_, bytes.data(), run);
  size_ += run;
  return bytes.subspan(run);
}

void HdlcReader::take(std::uint8_t byte) {
  if (state_ == State::kHunting) {
    ++faults_.bytes_between;
  } else if (state_ == State::kInside && byte == kEscape) {
    state_ = State::kEscaped;
  } else if (state_ != State::kOverlong) {
    if (size_ == kMaxFrame) {
      ++faults_.too_long;
      state_ = State::kOverlong;
      return;
    }
    buffer_[size_++] = state_ == State::kEscaped ? byte ^ kEscapeBit : byte;
    state_ = State::kInside;
  }
}

std::optional<HdlcFrame> HdlcReader::take_flag() {
  const std::size_t size = std::exchange(size_, 0);
  if (state_ == State::kEscaped) {  // synchronisation is lost: this flag starts no frame (wsn.md 2, rule 3)
    ++faults_.broken_escapes;
    state_ = State::kHunting;
    return std::nullopt;
  }
  const bool inside = std::exchange(state_, State::kInside) == State::kInside;
  return inside && size > 0 ? valid_frame(ByteView(buffer_).first(size)) : std::nullopt;
}

std::optional<HdlcFrame> HdlcReader::valid_frame(ByteView frame) {
  if (frame.size() < kMinFrame) {
    ++faults_.too_short;
    return std::nullopt;
  }
  const ByteView checked = frame.first(frame.size() - kCrcBytes);
  const auto written = static_cast<std::uint16_t>(frame[checked.size()] | frame[checked.size() + 1] << 8);
  if (crc16(checked) != written) {
    ++faults_.bad_crc;
    return std::nullopt;
  }
  switch (checked[0]) {
    case kHdlcAck: return HdlcFrame{kHdlcAck, checked[1], {}};
    case kHdlcAckedPacket: return HdlcFrame{kHdlcAckedPacket, checked[1], checked.subspan(2)};
    case kHdlcPacket: return HdlcFrame{kHdlcPacket, 0, checked.subspan(1)};
    case kUnknownProtocol: return std::nullopt;
    default: ++faults_.unknown_protocols; return std::nullopt;
  }
}

Bytes hdlc_ack(std::uint8_t sequence) {
  return frame_of(std::array{kHdlcAck, sequence}, {});
}

Bytes hdlc_acked_packet(std::uint8_t sequence, ByteView packet) {
  return frame_of(std::array{kHdlcAckedPacket, sequence}, packet);
}

Bytes hdlc_packet(ByteView packet) {
  return frame_of(std::array{kHdlcPacket}, packet);
}

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
