#include "motes/packet_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "motes/mote_packet.h"

namespace rubicon::motes {

namespace {

constexpr std::size_t kHeaderSize = 13;  // timestamp 8, direction 1, length 4 (log.md 1)
constexpr std::size_t kAmLength = 5;     // of the length field in a packet (wsn.md 3)

enum class Verdict { kValid, kInvalid, kNeedsMore };

struct Header {
  std::int64_t time = 0;
  std::uint8_t direction = 0;
  std::uint32_t length = 0;
};

Header read_header(ByteView bytes) {
  base::ByteReader reader(bytes);
  Header header;
  header.time = static_cast<std::int64_t>(reader.u64_be());
  header.direction = reader.u8();
  header.length = reader.u32_be();
  return header;
}

bool valid(const Header& header) {
  return header.direction <= 1 && header.length >= kAmOverhead && header.length <= kMaxPacket;
}

Verdict check(ByteView left) {
  if (left.size() < kHeaderSize) return Verdict::kNeedsMore;
  const Header header = read_header(left);
  if (!valid(header)) return Verdict::kInvalid;
  if (left.size() < kHeaderSize + header.length) return Verdict::kNeedsMore;
  const ByteView packet = left.subspan(kHeaderSize, header.length);
  const bool fits = packet[0] == 0 && packet[kAmLength] + kAmOverhead == packet.size();
  return fits ? Verdict::kValid : Verdict::kInvalid;
}

/// The fault of an invalid record; called at the start of damage only.
std::string fault_of(ByteView left) {
  if (check(left) == Verdict::kNeedsMore) return "record cut short by the end of the file";
  const Header header = read_header(left);
  if (header.direction > 1) return fmt::format("direction {}, expected 0 or 1", header.direction);
  if (!valid(header))
    return fmt::format("packet length {}, expected {} to {}", static_cast<std::int32_t>(header.length), kAmOverhead,
                       kMaxPacket);
  return fmt::format("dispatch byte {:02x} and AM length {} in a packet of {} bytes", left[kHeaderSize],
                     left[kHeaderSize + kAmLength], header.length);
}

}  // namespace

void PacketLogReader::feed(ByteView bytes) {
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(position_));
  buffer_offset_ += position_;
  position_ = 0;
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
}

void PacketLogReader::skip_one() {
  if (!damage_) damage_ = Damage{buffer_offset_ + position_, 0, fault_of(ByteView(buffer_).subspan(position_))};
  ++damage_->bytes;
  ++position_;
}

std::optional<PacketLogReader::Item> PacketLogReader::damage_or_nothing() {
  if (!damage_) return std::nullopt;
  return Item(*std::exchange(damage_, std::nullopt));
}

PacketRecord PacketLogReader::take_record() {
  const ByteView left = ByteView(buffer_).subspan(position_);
  const Header header = read_header(left);
  const ByteView packet = left.subspan(kHeaderSize, header.length);
  PacketRecord record{buffer_offset_ + position_, std::chrono::milliseconds(header.time), header.direction == 1,
                      Bytes(packet.begin(), packet.end())};
  position_ += kHeaderSize + packet.size();
  return record;
}

std::optional<PacketLogReader::Item> PacketLogReader::next() {
  while (position_ < buffer_.size()) {
    const Verdict verdict = check(ByteView(buffer_).subspan(position_));
    if (verdict == Verdict::kNeedsMore && !ended_) return std::nullopt;
    if (verdict == Verdict::kValid) {
      if (damage_) return damage_or_nothing();
      return Item(take_record());
    }
    skip_one();
  }
  return ended_ ? damage_or_nothing() : std::nullopt;
}

namespace {

constexpr std::size_t kHeaderBytes = 13;
/// Dispatch byte of a packet (wsn.md 3).
constexpr std::uint8_t kSerialDispatch = 0;
constexpr std::size_t kShown = 16;

}  // namespace

Result<Bytes> packet_log_record(std::chrono::milliseconds time, PacketDirection direction, ByteView packet) {
  if (packet.size() < kAmOverhead || packet.size() > kMaxPacket) {
    return fail(ErrorCode::kOutOfRange, fmt::format("recording a packet of {} bytes, expected {} to {}", packet.size(),
                                                    kAmOverhead, kMaxPacket));
  }
  base::ByteWriter record;
  record.u64_be(static_cast<std::uint64_t>(time.count()));
  record.u8(static_cast<std::uint8_t>(direction));
  record.u32_be(static_cast<std::uint32_t>(packet.size()));
  record.bytes(packet);
  return record.take();
}

Result<void> check_packet_log(ByteView beginning) {
  if (beginning.empty()) return {};
  base::ByteReader reader(beginning);
  reader.skip(8);
  const auto direction = reader.u8();
  const auto length = reader.u32_be();
  const auto dispatch = reader.u8();
  if (reader.ok() && direction <= 1 && length >= kAmOverhead && length <= kMaxPacket && dispatch == kSerialDispatch)
    return {};
  const auto shown = beginning.first(std::min(beginning.size(), kShown));
  return fail(ErrorCode::kInvalid,
              fmt::format("begins with {}, expected a record of {} bytes and a packet (time, direction 0 or 1, length)",
                          base::to_hex(shown), kHeaderBytes));
}

Result<void> PacketLogWriter::write(std::chrono::milliseconds time, PacketDirection direction, ByteView packet) {
  const auto record = packet_log_record(time, direction, packet);
  if (!record) return fail(record.error());
  if (auto written = sink_.append(*record); !written) return written;
  ++records_;
  return {};
}

}  // namespace rubicon::motes
