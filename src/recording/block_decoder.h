#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "base/bytes.h"
#include "recording/block.h"
#include "recording/record.h"

namespace rubicon::recording {

/// Decodes the records of one unpacked block, from any bytes. They must outlive it and its records.
class BlockDecoder {
 public:
  BlockDecoder() = default;
  BlockDecoder(const BlockHead& head, ByteView raw);

  /// The next record; nullopt at the end and after a fault.
  std::optional<Record> next();
  /// Why the bytes are not as many sound records as the head says; empty = they are.
  std::string_view fault() const { return fault_; }

 private:
  struct Known {
    OwnerId owner{};
    std::string_view key;
    std::uint64_t sequence = 0;
    std::size_t media_type = 0;
  };

  std::uint64_t number();
  std::string_view text(std::size_t size);
  std::int64_t after(std::int64_t time);
  std::uint8_t byte();
  Known* key_of(Record& record);
  void read_media_type(Known& known);
  std::optional<Record> stop(std::string_view why);

  const std::uint8_t* at_ = nullptr;
  const std::uint8_t* end_ = nullptr;
  bool truncated_ = false;
  std::uint32_t left_ = 0;
  std::int64_t seen_ = 0;
  std::vector<Known> keys_;
  std::vector<std::string_view> media_types_;
  std::string_view fault_;
};

}  // namespace rubicon::recording
