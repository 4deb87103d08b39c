#pragma once

#include <map>
#include <optional>

#include "base/bytes.h"
#include "transport/transports.h"

namespace rubicon::transport {

/// Files that exist in memory only: the twin of LocalTransports for tests, also for disks that fail.
class MemoryTransports final : public Transports {
 public:
  void put(const std::string& path, Bytes content) { files_[path].content = std::move(content); }
  void remove(const std::string& path) { files_.erase(path); }
  /// Reading at or behind this offset gives kIo.
  void fail_at(const std::string& path, std::uint64_t offset) { files_[path].fails_at = offset; }

  /// The file keeps the content it had when it was opened.
  Result<std::unique_ptr<FileSource>> open_file(const std::string& path) override;

  struct File {
    Bytes content;
    std::optional<std::uint64_t> fails_at;
  };

 private:
  std::map<std::string, File> files_;
};

}  // namespace rubicon::transport
