#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <variant>

#include "recording/block_decoder.h"
#include "recording/file_head.h"

struct ZSTD_DCtx_s;

namespace rubicon::recording {

/// A stretch of a file that could not be read, told once for the whole stretch.
struct Damage {
  std::uint64_t offset = 0;
  std::uint64_t bytes = 0;
  std::string why;
};

/// A sound block begins; its records follow.
struct BlockFound {
  std::uint64_t offset = 0;
  BlockHead head;
};

/// Takes the bytes of a recording in pieces of any size and gives its records. After damage it goes on at the next
/// sound block. Holds at most a piece, a block, its unpacked records and their keys, whatever the file claims.
class RecordingReader {
 public:
  using Item = std::variant<FileHead, BlockFound, Record, Damage>;

  /// `share`: about how many bytes one next() may look at, check and unpack without finding anything; a block is never
  /// divided.
  explicit RecordingReader(std::size_t share = std::numeric_limits<std::size_t>::max());
  ~RecordingReader();
  RecordingReader(RecordingReader&&) noexcept;
  RecordingReader& operator=(RecordingReader&&) noexcept;

  /// Appends bytes; call next() until it gives nothing before feeding more. Ends the views of records.
  void feed(ByteView bytes);
  /// No more bytes will come: what is left is damage. Without it a growing file can be followed.
  void end() { ended_ = true; }
  bool ended() const { return ended_; }
  /// The next item, or nothing until more bytes come (or for good, after end()), or when the share is used up.
  std::optional<Item> next();
  /// The last next() gave nothing because its share was used up: call it again before feeding.
  bool busy() const { return busy_; }

  /// The records of the block found last, from its beginning.
  BlockDecoder block() const;
  /// Where in the file the block found last begins.
  std::uint64_t block_offset() const { return offset_; }

 private:
  enum class Step { kAgain, kWait };
  Step look();
  Step look_at_head(ByteView rest);
  Step look_at_block(ByteView rest);
  Step skip(std::size_t bytes, std::string_view why);
  bool unpack(const BlockHead& head, ByteView packed);
  std::optional<Item> take_record();
  std::optional<Item> take_damage();

  std::size_t share_;
  std::size_t work_ = 0;
  bool busy_ = false;
  Bytes buffer_;
  std::size_t position_ = 0;
  std::uint64_t base_ = 0;  ///< file offset of buffer_[0]
  bool ended_ = false;
  std::optional<Damage> damage_;
  std::optional<Item> found_;
  Bytes raw_;
  BlockHead head_;
  std::uint64_t offset_ = 0;
  std::uint64_t end_of_block_ = 0;
  std::optional<BlockDecoder> records_;
  std::unique_ptr<ZSTD_DCtx_s, void (*)(ZSTD_DCtx_s*)> unpacker_;
};

}  // namespace rubicon::recording
