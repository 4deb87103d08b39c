#include "motes/packet_log_writer.h"

#include <fmt/format.h>

#include <algorithm>

namespace rubicon::motes {

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
