#include <cstdlib>

#include "fuzz_target.h"
#include "networks/log/foreign_recordings.h"

namespace rubicon::fuzz::packet_log_fuzz {

namespace {

/// Every byte is part of a record or of damage, in order, whatever the pieces.
void check_reader(ByteView content, std::size_t piece) {
  motes::PacketLogReader reader;
  std::uint64_t expected = 0;
  const auto drain = [&] {
    while (auto item = reader.next()) {
      if (const auto* record = std::get_if<motes::PacketRecord>(&*item)) {
        if (record->offset != expected) std::abort();
        expected += 13 + record->packet.size();
      } else {
        const auto& damage = std::get<motes::Damage>(*item);
        if (damage.offset != expected || damage.bytes == 0) std::abort();
        expected += damage.bytes;
      }
    }
  };
  for (std::size_t at = 0; at < content.size(); at += piece) {
    reader.feed(content.subspan(at, std::min(piece, content.size() - at)));
    drain();
  }
  reader.end();
  drain();
  if (expected != content.size()) std::abort();
}

}  // namespace

/// Input: one byte for the size of the pieces, then the content of a packet log.
FUZZ_TARGET(packet_log) {
  static const TypeCatalogue types;
  if (size == 0) return 0;
  const ByteView content(data + 1, size - 1);
  check_reader(content, data[0] + std::size_t{1});

  networks::log::ReplayCounters counters;
  networks::log::PacketRecording recording(types, {}, counters, [](std::uint64_t, std::string_view) {});
  networks::log::ReplayClock clock(1, std::nullopt, {});
  recording.begin("fuzz.bin", {});
  recording.feed(content);
  recording.end();
  while (const auto step = recording.next()) clock.due(clock.advance(step->time));
  return 0;
}

}  // namespace rubicon::fuzz::packet_log_fuzz
