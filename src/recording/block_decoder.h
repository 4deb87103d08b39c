#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "base/bytes.h"
#include "recording/block.h"
#include "recording/record.h"

namespace rubicon::recording {

/// Reads the records of one unpacked block. The bytes must outlive it and the records it gives. Takes any bytes.
class BlockDecoder {
 public:
  BlockDecoder() = default;
  BlockDecoder(const BlockHead& head, ByteView raw);

  /// The next record; nothing at the end, and from the first fault on.
  std::optional<Record> next();
  /// Empty unless the bytes are no sound records, or not as many as the head says.
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
  bool short_ = false;
  std::uint32_t left_ = 0;
  std::int64_t seen_ = 0;
  std::vector<Known> keys_;
  std::vector<std::string_view> media_types_;
  std::string_view fault_;
};

}  // namespace rubicon::recording
