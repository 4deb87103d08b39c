#pragma once

#include "transport/transports.h"

namespace rubicon::transport {

/// The machine's own files. Only regular ones: a FIFO or a device could block the loop.
class LocalTransports final : public Transports {
 public:
  Result<std::unique_ptr<FileSource>> open_file(const std::string& path) override;
  Result<std::unique_ptr<AppendFile>> open_append(const std::string& path) override;
  Result<void> rename_file(const std::string& from, const std::string& to) override;
  Result<void> remove_file(const std::string& path) override;
  Result<std::vector<std::string>> list_folder(const std::string& path) override;
};

}  // namespace rubicon::transport
