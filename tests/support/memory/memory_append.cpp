#include <algorithm>

#include "support/memory/memory_transports.h"

namespace rubicon::transport {

/// Looks up the file by its path at each call, so that renaming an open file has no effect here.
class MemoryTransports::MemoryAppendFile final : public AppendFile {
 public:
  MemoryAppendFile(MemoryTransports& disk, std::string path) : disk_(disk), path_(std::move(path)) {
    size_ = disk_.files_[path_].bytes.size();
  }
  ~MemoryAppendFile() override {
    if (const auto found = disk_.files_.find(path_); found != disk_.files_.end()) found->second.appending = false;
  }
  MemoryAppendFile(const MemoryAppendFile&) = delete;
  MemoryAppendFile& operator=(const MemoryAppendFile&) = delete;

  Result<void> append(ByteView bytes) override {
    const auto fits =
        static_cast<std::size_t>(std::min<std::uint64_t>(bytes.size(), disk_.room_.value_or(bytes.size())));
    auto& content = disk_.files_[path_].bytes;
    content.insert(content.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(fits));
    size_ += fits;
    if (disk_.room_) *disk_.room_ -= fits;
    if (fits == bytes.size()) return {};
    return fail(ErrorCode::kIo, path_ + ": cannot write: No space left on device");
  }

  std::uint64_t size() const override { return size_; }

  Result<void> truncate(std::uint64_t size) override {
    if (disk_.cuts_refused_) return fail(ErrorCode::kIo, path_ + ": cannot cut: Read-only file system");
    auto& content = disk_.files_[path_].bytes;
    if (disk_.room_ && size < content.size()) *disk_.room_ += content.size() - size;
    content.resize(static_cast<std::size_t>(size));
    size_ = size;
    return {};
  }

 private:
  MemoryTransports& disk_;
  std::string path_;
  std::uint64_t size_ = 0;
};

bool MemoryTransports::is_lost(const std::string& path) const {
  const auto slash = path.rfind('/');
  return lost_.contains(slash == path.npos ? std::string() : path.substr(0, slash));
}

Result<std::unique_ptr<AppendFile>> MemoryTransports::open_append(const std::string& path) {
  if (is_lost(path)) return fail(ErrorCode::kNotFound, path + ": cannot open for writing: No such file or directory");
  auto& file = files_[path];
  if (std::exchange(file.appending, true)) return fail(ErrorCode::kBusy, path + ": another program is writing to it");
  return std::make_unique<MemoryAppendFile>(*this, path);
}

Result<void> MemoryTransports::rename_file(const std::string& from, const std::string& to) {
  if (renames_refused_ || is_lost(from))
    return fail(ErrorCode::kIo, from + ": cannot be renamed to " + to + ": Read-only file system");
  if (files_.contains(to))
    return fail(ErrorCode::kDuplicate, from + ": cannot be renamed to " + to + ": that exists already");
  auto file = files_.extract(from);
  if (file.empty()) return fail(ErrorCode::kNotFound, from + ": cannot be renamed to " + to + ": no such file");
  file.key() = to;
  files_.insert(std::move(file));
  return {};
}

Result<void> MemoryTransports::remove_file(const std::string& path) {
  if (files_.erase(path) == 0) return fail(ErrorCode::kNotFound, path + ": cannot remove: no such file");
  return {};
}

Result<std::vector<std::string>> MemoryTransports::list_folder(const std::string& path) {
  const auto before = path.empty() ? std::string() : path + '/';
  std::vector<std::string> names;
  for (const auto& [name, file] : files_) {
    if (name.starts_with(before) && name.find('/', before.size()) == name.npos)
      names.push_back(name.substr(before.size()));
  }
  return names;
}

std::vector<std::string> MemoryTransports::paths() const {
  std::vector<std::string> all;
  for (const auto& [name, file] : files_) all.push_back(name);
  return all;
}

}  // namespace rubicon::transport
