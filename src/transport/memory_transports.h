#pragma once

#include <map>
#include <optional>

#include "base/bytes.h"
#include "transport/transports.h"

namespace rubicon::transport {

/// The twin of LocalTransports for tests: files of memory that can fail where a test wants. Outlives the files it
/// opened.
class MemoryTransports final : public Transports {
 public:
  struct File {
    Bytes bytes;
    std::optional<std::uint64_t> fails_at;  ///< reading this offset is an I/O error
  };

  void put(const std::string& path, Bytes bytes) { files_[path] = {std::move(bytes), std::nullopt}; }
  void put(const std::string& path, std::string_view text);
  void fail_at(const std::string& path, std::uint64_t offset) { files_[path].fails_at = offset; }
  void remove(const std::string& path) { files_.erase(path); }

  Result<std::unique_ptr<FileSource>> open_file(const std::string& path) override;

 private:
  std::map<std::string, File> files_;
};

}  // namespace rubicon::transport
