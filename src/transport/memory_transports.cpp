#include "transport/memory_transports.h"

#include <fmt/format.h>

#include <algorithm>

namespace rubicon::transport {

namespace {

class MemoryFile final : public FileSource {
 public:
  MemoryFile(MemoryTransports::File file, std::string path) : file_(std::move(file)), path_(std::move(path)) {}

  Result<std::size_t> read(std::span<std::uint8_t> into) override {
    if (file_.fails_at && position_ >= *file_.fails_at) {
      return fail(ErrorCode::kIo, fmt::format("reading {}: failed at offset {}", path_, position_));
    }
    const auto end = std::min<std::uint64_t>(file_.content.size(), file_.fails_at.value_or(file_.content.size()));
    const auto count = std::min<std::uint64_t>(into.size(), end > position_ ? end - position_ : 0);
    const auto from = file_.content.begin() + static_cast<std::ptrdiff_t>(position_);
    std::copy_n(from, count, into.begin());
    position_ += count;
    return static_cast<std::size_t>(count);
  }

  Result<void> seek(std::uint64_t offset) override {
    position_ = std::min<std::uint64_t>(offset, file_.content.size());
    return {};
  }

  std::uint64_t size() const override { return file_.content.size(); }

 private:
  MemoryTransports::File file_;
  std::string path_;
  std::uint64_t position_ = 0;
};

}  // namespace

Result<std::unique_ptr<FileSource>> MemoryTransports::open_file(const std::string& path) {
  const auto found = files_.find(path);
  if (found == files_.end()) return fail(ErrorCode::kNotFound, fmt::format("opening {}: no such file", path));
  return std::make_unique<MemoryFile>(found->second, path);
}

}  // namespace rubicon::transport
