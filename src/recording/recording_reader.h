#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "base/bytes.h"
#include "recording/file_format.h"
#include "recording/record.h"

struct ZSTD_DCtx_s;

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

/// Puts the next bytes of a file into the place and returns how many; 0 = the end.
using ReadPiece = std::function<Result<std::size_t>(std::span<std::uint8_t> into)>;
/// An item is valid during the call.
using VisitItem = std::function<Result<void>(const RecordingReader::Item& item)>;

/// Visits all that is in a file that does not grow, in its order. Ends with the first error of reading or visiting.
Result<void> each_item(const ReadPiece& read, const VisitItem& visit);

/// Reads a file at an offset; fewer bytes than asked for only at its end.
using ReadAt = std::function<Result<std::size_t>(std::uint64_t offset, std::span<std::uint8_t> into)>;

/// How far a file is sound that is to be continued.
struct FileTail {
  bool has_head = false;  ///< false: the file is empty, or has the beginning of a head
  FileHead head;
  std::uint64_t sound = 0;         ///< end of the last sound block, where the file must be cut off
  std::optional<WallTime> last{};  ///< when its last record was seen; nullopt = there is no sound block
};

/// A longer damaged tail, in bytes, does not come from a crash: it is not searched and not cut off.
inline constexpr std::uint64_t kMaxTail = 32 << 20;

/// Searches backwards from the end, so that it is fast for large files with a sound end. Limited in what it reads and
/// checks, whatever the file holds. kInvalid if the file is not a recording, its head is damaged or no sound block is
/// near its end; kUnsupported if it is of a newer version; otherwise the errors of `read`.
Result<FileTail> find_tail(std::uint64_t size, const ReadAt& read);

}  // namespace rubicon::recording
