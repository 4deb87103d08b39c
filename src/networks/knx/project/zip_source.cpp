#include "networks/knx/project/zip_source.h"

#include <algorithm>

#include "networks/knx/secure/key.h"

namespace rubicon::networks::knx::project {

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
