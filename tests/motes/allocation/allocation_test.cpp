#include <gtest/gtest.h>

#include <cstdlib>
#include <new>

#include "motes/framing.h"
#include "motes/mote_records.h"

// A program of its own, because it counts every allocation there is.

namespace {

std::size_t allocations = 0;

void* counted(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size == 0 ? 1 : size)) return memory;
  std::abort();
}

}  // namespace

void* operator new(std::size_t size) {
  return counted(size);
}
void* operator new[](std::size_t size) {
  return counted(size);
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete[](void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
void operator delete[](void* memory, std::size_t) noexcept {
  std::free(memory);
}

namespace rubicon::motes {
namespace {

Bytes packet_with(std::uint8_t transport, std::uint8_t application, ByteView record) {
  NetMessage message{11, kBaseMote, 11, 5, 0, 0x1234, 0, transport, application, record};
  return packet_of(message);
}

/// A packet of each kind of record, and one that fills an UPDATES record.
std::vector<Bytes> packets() {
  RawUpdates full;
  for (std::uint16_t i = 0; i < 24; ++i) full.readings.push_back({1, {i}});
  const RawUpdates multi{{{0x0004, {500, 9}}, {0x0100, {1, 2, 3, 4, 5}}}};
  const auto control = [](const Record& record) { return packet_with(3, kApplicationControl, encode_record(record)); };
  const auto mockup = [](const Record& record) { return packet_with(3, kApplicationMockup, encode_record(record)); };
  return {control(Joined{11, 5, 1, 0x1f4f, 1}),
          control(full),
          control(multi),
          control(ReadUpdates{500, 0x43}),
          mockup(DemoReport{300, 6500}),
          mockup(PeriodicCommand{0x43, 1000}),
          mockup(ActuateCommand{1, -1}),
          packet_with(kTransportAck, 5, encode_record(MoteAck{0xbeef, 0})),
          packet_with(3, 6, Bytes{0x19, 2, 0, 0, 0x40, 0x3f})};
}

struct Read {
  std::size_t records = 0, words = 0;
};

void read_packet(ByteView bytes, Read& read) {
  const auto packet = decode_whole(bytes);
  if (!packet || !packet->radio) return;
  ++read.records;
  if (const auto* updates = std::get_if<RawUpdates>(&packet->radio->record)) {
    for (const RawReading& reading : updates->readings) read.words += reading.words.size();
  }
}

TEST(MoteAllocation, IsCounted) {
  const std::size_t before = allocations;
  const auto bytes = std::make_unique<Bytes>(100);
  EXPECT_GE(allocations - before, 2u);
}

TEST(MoteAllocation, NoneFromTheSerialLineToTheRecord) {
  Bytes line{1, 2, 3};  // and faults on the way: garbage, a wrong CRC, an over-long frame
  for (const Bytes& packet : packets()) {
    for (const Bytes& frame : {hdlc_packet(packet), hdlc_acked_packet(0x7e, packet), hdlc_ack(0x7d),
                               Bytes{0x7e, 0x45, 0, 0, 1, 2, 3, 0x7e}, hdlc_packet(Bytes(300))})
      line.insert(line.end(), frame.begin(), frame.end());
  }
  for (const std::size_t piece : {std::size_t{1}, std::size_t{50}, line.size()}) {
    HdlcReader reader;
    Read read;
    const std::size_t before = allocations;
    for (std::size_t at = 0; at < line.size(); at += piece) {
      ByteView bytes = ByteView(line).subspan(at, std::min(piece, line.size() - at));
      while (const auto frame = reader.next(bytes)) {
        if (frame->protocol != kHdlcAck) read_packet(frame->packet, read);
      }
    }
    EXPECT_EQ(allocations - before, 0u) << piece;
    EXPECT_EQ(read.records, 18u) << piece;
    EXPECT_EQ(read.words, 2u * (24 + 7)) << piece;
    EXPECT_EQ(reader.faults().bad_crc, 9u) << piece;
    EXPECT_EQ(reader.faults().too_long, 9u) << piece;
  }
}

TEST(MoteAllocation, NoneFromAForwarderToTheRecord) {
  Bytes stream(kForwarderHello.begin(), kForwarderHello.end());
  for (const Bytes& packet : packets()) {
    const Bytes framed = forwarder_packet(packet);
    stream.insert(stream.end(), framed.begin(), framed.end());
  }
  ForwarderReader reader;
  Read read;
  ByteView bytes = stream;
  const std::size_t before = allocations;
  while (true) {
    const auto packet = reader.next(bytes);
    if (!packet || !*packet) break;
    read_packet(**packet, read);
  }
  EXPECT_EQ(allocations - before, 0u);
  EXPECT_EQ(read.records, 9u);
}

}  // namespace
}  // namespace rubicon::motes
