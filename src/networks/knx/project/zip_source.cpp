#include "networks/knx/project/zip_source.h"

#include <algorithm>
#include <optional>
#include <string_view>

#include "base/bytes.h"
#include "networks/knx/secure/key.h"

namespace rubicon::networks::knx::project {

namespace {

constexpr std::string_view kEnd = "PK\x05\x06", kLocator64 = "PK\x06\x07", kEnd64 = "PK\x06\x06";
constexpr std::size_t kEndSize = 22, kLocator64Size = 20, kEnd64Size = 56;
constexpr std::size_t kMaxComment = 0xffff;

/// A number, low byte first.
std::uint64_t number_at(ByteView bytes, std::size_t at, std::size_t size) {
  std::uint64_t value = 0;
  for (std::size_t i = size; i > 0; --i) value = value << 8U | bytes[at + i - 1];
  return value;
}

Result<Bytes> read_at(transport::FileSource& file, std::uint64_t at, std::size_t size) {
  if (auto moved = file.seek(at); !moved) return fail(moved.error());
  Bytes bytes(size);
  std::size_t done = 0;
  while (done < size) {
    const auto count = file.read(std::span(bytes).subspan(done));
    if (!count) return fail(count.error());
    if (*count == 0) break;
    done += *count;
  }
  bytes.resize(done);
  return bytes;
}

/// The claims of the record for large archives, if the locator before the end record at `at` leads to one.
Result<std::optional<ArchiveEnd>> end64_before(transport::FileSource& file, ByteView tail, std::size_t at) {
  if (at < kLocator64Size) return std::nullopt;
  const auto locator = tail.subspan(at - kLocator64Size, kLocator64Size);
  if (!base::as_text(locator).starts_with(kLocator64)) return std::nullopt;
  const auto record = read_at(file, number_at(locator, 8, 8), kEnd64Size);
  if (!record) return fail(record.error());
  if (record->size() < kEnd64Size || !base::as_text(*record).starts_with(kEnd64)) return std::nullopt;
  return ArchiveEnd{number_at(*record, 32, 8), number_at(*record, 40, 8)};
}

}  // namespace

Result<ArchiveEnd> read_archive_end(transport::FileSource& file) {
  constexpr std::size_t kTail = kMaxComment + kEndSize + kLocator64Size;
  const auto size = static_cast<std::size_t>(std::min<std::uint64_t>(file.size(), kTail));
  const auto tail = read_at(file, file.size() - size, size);
  if (!tail) return fail(tail.error());
  const auto text = base::as_text(*tail);
  ArchiveEnd most;
  bool found = false;
  for (auto at = text.find(kEnd); at != text.npos; at = text.find(kEnd, at + 1)) {
    if (at + kEndSize > text.size()) break;
    found = true;
    const auto large = end64_before(file, *tail, at);
    if (!large) return fail(large.error());
    const auto claims = large->value_or(ArchiveEnd{number_at(*tail, at + 10, 2), number_at(*tail, at + 12, 4)});
    most = {std::max(most.entries, claims.entries), std::max(most.directory, claims.directory)};
  }
  if (!found) return fail(ErrorCode::kInvalid, "not a zip archive, or its end is missing");
  return most;
}

namespace {

/// What libzip asks of a source (zip_source_function(3)).
class ZipSource {
 public:
  explicit ZipSource(std::unique_ptr<transport::FileSource> file) : file_(std::move(file)) {
    ::zip_error_init(&error_);
  }
  ~ZipSource() { ::zip_error_fini(&error_); }
  ZipSource(const ZipSource&) = delete;
  ZipSource& operator=(const ZipSource&) = delete;

  zip_int64_t answer(void* bytes, zip_uint64_t size, zip_source_cmd_t command) {
    switch (command) {
      case ZIP_SOURCE_OPEN: return seek_to(0) ? 0 : -1;
      case ZIP_SOURCE_READ: return read({static_cast<std::uint8_t*>(bytes), size});
      case ZIP_SOURCE_SEEK: return seek(bytes, size);
      case ZIP_SOURCE_TELL: return static_cast<zip_int64_t>(at_);
      case ZIP_SOURCE_CLOSE: return 0;
      case ZIP_SOURCE_STAT: return describe(*static_cast<zip_stat_t*>(bytes));
      case ZIP_SOURCE_ERROR: return ::zip_error_to_data(&error_, bytes, size);
      case ZIP_SOURCE_SUPPORTS:
        return ::zip_source_make_command_bitmap(ZIP_SOURCE_OPEN, ZIP_SOURCE_READ, ZIP_SOURCE_CLOSE, ZIP_SOURCE_STAT,
                                                ZIP_SOURCE_ERROR, ZIP_SOURCE_FREE, ZIP_SOURCE_SEEK, ZIP_SOURCE_TELL,
                                                ZIP_SOURCE_SUPPORTS, -1);
      default: return failed(ZIP_ER_OPNOTSUPP);
    }
  }

 private:
  zip_int64_t failed(int code) {
    ::zip_error_set(&error_, code, 0);
    return -1;
  }

  bool seek_to(std::uint64_t offset) {
    if (!file_->seek(offset)) {
      failed(ZIP_ER_SEEK);
      return false;
    }
    at_ = offset;
    return true;
  }

  zip_int64_t seek(void* bytes, zip_uint64_t size) {
    const auto offset = ::zip_source_seek_compute_offset(at_, file_->size(), bytes, size, &error_);
    return offset >= 0 && seek_to(static_cast<std::uint64_t>(offset)) ? 0 : -1;
  }

  zip_int64_t read(std::span<std::uint8_t> into) {
    const auto count = file_->read(into);
    if (!count) return failed(ZIP_ER_READ);
    at_ += *count;
    return static_cast<zip_int64_t>(*count);
  }

  zip_int64_t describe(zip_stat_t& out) const {
    ::zip_stat_init(&out);
    out.size = file_->size();
    out.valid |= ZIP_STAT_SIZE;
    return sizeof(out);
  }

  std::unique_ptr<transport::FileSource> file_;
  std::uint64_t at_ = 0;
  zip_error_t error_{};
};

zip_int64_t answer(void* user, void* bytes, zip_uint64_t size, zip_source_cmd_t command) {
  auto* source = static_cast<ZipSource*>(user);
  if (command != ZIP_SOURCE_FREE) return source->answer(bytes, size, command);
  delete source;  // NOLINT(cppcoreguidelines-owning-memory): libzip owns it
  return 0;
}

class BytesFile final : public transport::FileSource {
 public:
  explicit BytesFile(Bytes content) : content_(std::move(content)) {}
  ~BytesFile() override { secure::wipe(content_); }

  Result<std::size_t> read(std::span<std::uint8_t> into) override {
    const auto count = std::min(into.size(), content_.size() - at_);
    std::copy_n(content_.begin() + static_cast<std::ptrdiff_t>(at_), count, into.begin());
    at_ += count;
    return count;
  }
  Result<void> seek(std::uint64_t offset) override {
    at_ = static_cast<std::size_t>(std::min<std::uint64_t>(offset, content_.size()));
    return {};
  }
  std::uint64_t size() const override { return content_.size(); }

 private:
  Bytes content_;
  std::size_t at_ = 0;
};

}  // namespace

zip_source_t* zip_source_of(std::unique_ptr<transport::FileSource> file, zip_error_t* error) {
  auto source = std::make_unique<ZipSource>(std::move(file));
  auto* made = ::zip_source_function_create(&answer, source.get(), error);
  if (made != nullptr) static_cast<void>(source.release());
  return made;
}

std::unique_ptr<transport::FileSource> file_of(Bytes content) {
  return std::make_unique<BytesFile>(std::move(content));
}

}  // namespace rubicon::networks::knx::project
