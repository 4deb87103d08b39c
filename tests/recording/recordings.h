#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "recording/block_builder.h"
#include "recording/file_format.h"
#include "recording/recording_reader.h"

namespace rubicon::recording {

/// A record that owns its text.
struct Line {
  RecordKind kind = RecordKind::kSet;
  std::int64_t seen = 0;
  std::uint32_t owner = 6541;
  std::string key, value, media_type = "text/plain";
  std::uint32_t creator = 6541;
  std::uint64_t sequence = 1;
  std::int64_t write = 0, user = 0, expire = 0;

  friend bool operator==(const Line&, const Line&) = default;
};

inline WallTime wall(std::int64_t micros) {
  return WallTime(std::chrono::microseconds(micros));
}

inline Record record_of(const Line& line) {
  return {line.kind,        wall(line.seen), OwnerId(line.owner),   line.key,
          line.value,       line.media_type, OwnerId(line.creator), line.sequence,
          wall(line.write), wall(line.user), wall(line.expire)};
}

inline Line line_of(const Record& record) {
  const auto micros = [](WallTime time) { return time.time_since_epoch().count(); };
  return {record.kind,
          micros(record.seen),
          number(record.owner),
          std::string(record.key),
          std::string(record.value),
          std::string(record.media_type),
          number(record.creator),
          record.sequence,
          micros(record.write_time),
          micros(record.user_time),
          micros(record.expire_time)};
}

inline Line reading(int number, std::string value) {
  const std::int64_t time = 1'700'000'000'000'000 + number * 1000;
  Line line;
  line.seen = time + 3;
  line.key = "proxy.wsn-1." + std::to_string(number % 3) + ".sensor.light-1.value";
  line.value = std::move(value);
  line.sequence = static_cast<std::uint64_t>(number / 3 + 2);
  line.write = time;
  line.user = time - 20;
  return line;
}

inline void append(Bytes& to, ByteView more) {
  to.insert(to.end(), more.begin(), more.end());
}

/// A head and blocks of these lines.
inline Bytes file_of(const std::vector<std::vector<Line>>& blocks) {
  Bytes file = encode_head({IslandId(6541), "proxy", wall(1'700'000'000'000'000), "test"});
  BlockBuilder builder;
  for (const auto& lines : blocks) {
    for (const auto& line : lines) EXPECT_TRUE(builder.add(record_of(line)));
    append(file, builder.close());
  }
  return file;
}

/// Three blocks of four readings.
inline std::vector<std::vector<Line>> three_blocks() {
  std::vector<std::vector<Line>> blocks(3);
  for (int i = 0; i < 12; ++i) blocks[static_cast<std::size_t>(i / 4)].push_back(reading(i, std::to_string(i) + ".5"));
  return blocks;
}

/// Everything a reader finds, fed in pieces.
struct Found {
  std::vector<FileHead> heads;
  std::vector<Line> lines;
  std::vector<Damage> damage;
  std::vector<std::uint64_t> blocks;

  std::uint64_t damaged_bytes() const {
    std::uint64_t sum = 0;
    for (const auto& one : damage) sum += one.bytes;
    return sum;
  }
};

inline void drain(RecordingReader& reader, Found& found) {
  while (auto item = reader.next()) {
    if (const auto* head = std::get_if<FileHead>(&*item)) found.heads.push_back(*head);
    if (const auto* block = std::get_if<BlockFound>(&*item)) found.blocks.push_back(block->offset);
    if (const auto* record = std::get_if<Record>(&*item)) found.lines.push_back(line_of(*record));
    if (const auto* damage = std::get_if<Damage>(&*item)) found.damage.push_back(*damage);
  }
}

inline Found read_all(ByteView file, std::size_t piece = 64 * 1024) {
  RecordingReader reader;
  Found found;
  for (std::size_t at = 0; at < file.size(); at += piece) {
    reader.feed(file.subspan(at, std::min(piece, file.size() - at)));
    drain(reader, found);
  }
  reader.end();
  drain(reader, found);
  return found;
}

}  // namespace rubicon::recording
