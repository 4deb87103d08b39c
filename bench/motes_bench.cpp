#include <benchmark/benchmark.h>

#include <cstring>

#include "model/type_catalogue.h"
#include "motes/framing.h"
#include "motes/mote_codec.h"
#include "networks/wsn/recent_messages.h"

// What it costs to read the sink's serial line: flags, escapes and CRC, packet, radio message, record. The goal is
// 2,000,000 frames a second on one core. The floor beside it copies the same bytes once and runs the CRC over them.

namespace rubicon::motes {
namespace {

constexpr std::size_t kRadioRecord = 100;
constexpr std::uint16_t kIsland = 11;

/// A frame as sinks forward them: 127 bytes where nothing is escaped, the record padded, nbytes lying (wsn.md 5).
Bytes forwarded(std::uint16_t mote, std::uint16_t sequence, std::uint8_t application, const Record& record) {
  Bytes padded = encode_record(record);
  padded.resize(kRadioRecord);
  NetMessage message;
  message.destination_island = message.source_island = kIsland;
  message.destination_mote = kBaseMote;
  message.source_mote = mote;
  message.sequence = sequence;
  message.counted = 0x66;
  message.transport = kTransportConnectionless;
  message.application = application;
  message.record = padded;
  const Bytes payload = encode_net(message);
  MotePacket packet;
  packet.am = {0xffff, 0, 0x72, 0, static_cast<std::uint8_t>(AmType::kNetMessage)};
  packet.payload = payload;
  return hdlc_packet(encode_packet(packet));
}

RawUpdates updates_of_a_board(std::uint16_t n) {
  const auto ramp = [n](int start, int step) { return static_cast<std::uint16_t>(start + step * n); };
  return {{{0x0001, {ramp(300, 7)}},
           {0x0002, {ramp(6500, 1)}},
           {0x0004, {ramp(500, 1), 9}},
           {0x0008, {ramp(480, 1), 7}},
           {0x0040, {ramp(1200, 3)}},
           {0x0100, {40, 41, 42, 43, 44}}}};
}

/// 1,000 frames: of ten one join, five updates and four of demo data, the values ramps.
Bytes recorded_like() {
  Bytes line;
  for (std::uint16_t n = 0; n < 1000; ++n) {
    const auto mote = static_cast<std::uint16_t>(2 + n % 20);
    Bytes frame;
    if (n % 10 == 0) {
      frame = forwarded(mote, 0, kApplicationControl, Joined{kIsland, mote, 1, 0x1f4f, 1});
    } else if (n % 10 < 6) {
      frame = forwarded(mote, static_cast<std::uint16_t>(n * 769U), kApplicationControl, updates_of_a_board(n));
    } else {
      const DemoReport demo{static_cast<std::uint16_t>(300 + 7 * n), static_cast<std::uint16_t>(6500 + n)};
      frame = forwarded(mote, static_cast<std::uint16_t>(n * 769U), kApplicationMockup, demo);
    }
    line.insert(line.end(), frame.begin(), frame.end());
  }
  return line;
}

/// Frames whose records were read.
std::size_t read_line(HdlcReader& reader, ByteView bytes) {
  std::size_t records = 0;
  while (const auto frame = reader.next(bytes)) {
    const auto packet = decode_packet(frame->packet);
    if (!packet) continue;
    const auto message = decode_net(packet->payload);
    if (!message) continue;
    auto record = decode_record(*message);
    benchmark::DoNotOptimize(record);
    records += record ? 1U : 0U;
  }
  return records;
}

void frames(benchmark::State& state) {
  const Bytes line = recorded_like();
  const auto piece = static_cast<std::size_t>(state.range(0));
  HdlcReader reader;
  std::size_t records = 0;
  for (auto _ : state) {
    for (std::size_t at = 0; at < line.size(); at += piece)
      records += read_line(reader, ByteView(line).subspan(at, std::min(piece, line.size() - at)));
  }
  if (records != static_cast<std::size_t>(state.iterations()) * 1000) state.SkipWithError("frames were lost");
  state.SetItemsProcessed(static_cast<std::int64_t>(records));
  state.SetBytesProcessed(static_cast<std::int64_t>(line.size()) * state.iterations());
}
BENCHMARK(frames)->Name("mote/frames")->ArgName("piece")->Arg(64)->Arg(4096)->Arg(1 << 20);

void floor_of_frames(benchmark::State& state) {
  const Bytes line = recorded_like();
  Bytes copy(line.size());
  for (auto _ : state) {
    for (std::size_t at = 0; at < line.size(); at += 127) {
      const std::size_t size = std::min<std::size_t>(127, line.size() - at);
      std::memcpy(copy.data() + at, line.data() + at, size);
      auto crc = crc16(ByteView(copy).subspan(at, size));
      benchmark::DoNotOptimize(crc);
    }
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * 1000);
  state.SetBytesProcessed(static_cast<std::int64_t>(line.size()) * state.iterations());
}
BENCHMARK(floor_of_frames)->Name("mote/frames-floor");

/// The packets of the line above.
std::vector<Bytes> packets_on(ByteView line) {
  HdlcReader reader;
  std::vector<Bytes> packets;
  while (const auto frame = reader.next(line)) packets.emplace_back(frame->packet.begin(), frame->packet.end());
  return packets;
}

/// What a wsn network spends on each packet of its sink: packet to messages in physical units, and the check for
/// repetitions.
void received(benchmark::State& state) {
  const auto packets = packets_on(recorded_like());
  const TypeCatalogue types;
  CodecOptions options;
  options.island = kIsland;
  MoteCodec codec(types, options);
  networks::wsn::RecentMessages recent;
  SteadyTime now{};
  for (auto _ : state) {
    for (const Bytes& bytes : packets) {
      const auto packet = decode_whole(bytes);
      auto events = codec.interpret(*packet);
      benchmark::DoNotOptimize(events);
      bool repeated = recent.seen(packet->radio->header, now += std::chrono::milliseconds(10));
      benchmark::DoNotOptimize(repeated);
    }
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(packets.size()));
}
BENCHMARK(received)->Name("mote/received");

}  // namespace
}  // namespace rubicon::motes
