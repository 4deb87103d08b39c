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

/// A part of a file that could not be read.
struct Damage {
  std::uint64_t offset = 0;
  std::uint64_t bytes = 0;
  std::string why;
};

/// The beginning of a sound block; its records follow.
struct BlockFound {
  std::uint64_t offset = 0;
  BlockHead head;
};

/// Reads the records of a recording that is fed in pieces of any size. After damage it continues at the next sound
/// block. Holds at most a piece, a block, its unpacked records and their keys, whatever lengths the file has.
class RecordingReader {
 public:
  using Item = std::variant<FileHead, BlockFound, Record, Damage>;

  /// `budget`: about how many bytes one next() searches, checks and unpacks without a result; a block is never divided.
  explicit RecordingReader(std::size_t budget = std::numeric_limits<std::size_t>::max());
  ~RecordingReader();
  RecordingReader(RecordingReader&&) noexcept;
  RecordingReader& operator=(RecordingReader&&) noexcept;

  /// Appends bytes. Call it when next() returned nothing and busy() is false. Invalidates the views of records.
  void feed(ByteView bytes);
  /// The file has no more bytes: the rest is damage. Not to be called for a file that still grows.
  void end() { ended_ = true; }
  bool ended() const { return ended_; }
  /// The next item; nullopt if it needs more bytes, at the end, or when the budget is used up.
  std::optional<Item> next();
  /// The last next() used up its budget: call it again before feeding more.
  bool busy() const { return busy_; }

  /// The records of the last block, from its beginning.
  BlockDecoder block() const;
  /// Where in the file the last block begins.
  std::uint64_t block_offset() const { return offset_; }

 private:
  enum class Progress { kMade, kNeedsBytes };
  Progress parse();
  Progress parse_head(ByteView rest);
  Progress parse_block(ByteView rest);
  Progress skip(std::size_t bytes, std::string_view why);
  bool unpack(const BlockHead& head, ByteView packed);
  std::optional<Item> take_record();
  std::optional<Item> take_damage();

  std::size_t budget_;
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
