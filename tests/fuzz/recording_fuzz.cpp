#include <cstdlib>

#include "fuzz_target.h"
#include "networks/log/tuple_recording.h"
#include "recording/block_builder.h"

namespace rubicon::fuzz::recording_fuzz {

namespace {

using recording::BlockHead;
using recording::Record;
using recording::RecordingReader;

/// Every byte is part of a head, a block or damage, whatever the pieces; nothing is given twice.
void check_reader(ByteView content, std::size_t piece) {
  RecordingReader reader;
  std::uint64_t damaged = 0;
  const auto drain = [&] {
    while (const auto item = reader.next()) {
      if (const auto* damage = std::get_if<recording::Damage>(&*item)) {
        if (damage->bytes == 0 || damage->offset + damage->bytes > content.size()) std::abort();
        damaged += damage->bytes;
      }
      const auto* record = std::get_if<Record>(&*item);
      if (record != nullptr && (record->key.size() > recording::kMaxKey || record->value.size() > recording::kMaxRaw))
        std::abort();
    }
  };
  for (std::size_t at = 0; at < content.size(); at += piece) {
    reader.feed(content.subspan(at, std::min(piece, content.size() - at)));
    drain();
  }
  reader.end();
  drain();
  if (damaged > content.size()) std::abort();
}

/// The records of an unpacked block, as behind a sound check sum; what is read can be written and read again.
Bytes check_records(ByteView raw) {
  BlockHead head;
  head.records = 1 + static_cast<std::uint32_t>(raw.size()) / 16;
  recording::BlockDecoder records(head, raw);
  recording::BlockBuilder builder(1);
  Bytes blocks = recording::encode_head({IslandId(6541), "proxy", {}, "fuzz"});
  while (const auto record = records.next()) builder.add(*record);
  if (builder.empty()) return blocks;
  const auto count = builder.records();
  const auto block = builder.close();
  if (recording::sound_block(block) != block.size()) std::abort();
  if (recording::decode_block_head(block)->records != count) std::abort();
  blocks.insert(blocks.end(), block.begin(), block.end());
  return blocks;
}

void check_replay(ByteView content) {
  static const TypeCatalogue types;
  networks::log::ReplayCounters counters;
  networks::log::TupleRecording recording(types, "wsn-1", counters, [](std::uint64_t, std::string_view) {});
  recording.begin("fuzz.rec", {});
  recording.feed(content);
  recording.end();
  do {
    while (const auto step = recording.next()) {
      if (step->messages.empty()) std::abort();
    }
  } while (recording.has_more());
}

}  // namespace

/// Input: one byte for the size of the pieces, zero = what follows are the records of an unpacked block; else a file.
FUZZ_TARGET(recording) {
  if (size == 0) return 0;
  const ByteView content(data + 1, size - 1);
  if (data[0] == 0) {
    check_replay(check_records(content));
  } else {
    check_reader(content, data[0]);
    check_replay(content);
  }
  return 0;
}

}  // namespace rubicon::fuzz::recording_fuzz
