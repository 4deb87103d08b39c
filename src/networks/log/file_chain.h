#pragma once

#include <memory>
#include <string>
#include <vector>

#include "networks/log/recording.h"
#include "transport/transports.h"

namespace rubicon::networks::log {

/// Reads files one after the other, in pieces of 64 KiB, through a recording format.
class FileChain {
 public:
  enum class Found { kStep, kNextFile, kNothingYet, kEnd };

  FileChain(transport::Transports& transports, Recording& recording);

  /// Opens the first of these files; after a failure, the one that failed.
  Result<void> open(std::vector<std::string> files);
  /// Opens the first file again.
  Result<void> rewind();
  /// Reads at most one piece. kStep: `step` is filled; kNextFile: the next file begins; kNothingYet: call it again.
  Result<Found> next(Step& step);

  const std::string& path() const { return files_[index_]; }

 private:
  Result<void> open_current();
  Result<std::string> label_of(const std::string& table, const std::string& key);

  transport::Transports& transports_;
  Recording& recording_;
  std::vector<std::string> files_;
  std::string directory_;
  std::size_t index_ = 0;
  std::unique_ptr<transport::FileSource> file_;
  Bytes piece_;
  bool ended_ = false;
};

}  // namespace rubicon::networks::log
