#pragma once

#include <memory>
#include <string>
#include <vector>

#include "networks/log/recording.h"
#include "transport/transports.h"

namespace rubicon::networks::log {

/// Reads a list of files, one after the other and in pieces of 64 KiB, through a recording format.
class FileChain {
 public:
  enum class Got { kStep, kNextFile, kNothingYet, kEnd };

  FileChain(transport::Transports& transports, Recording& recording);

  /// Opens the first of these files, or after a failure the one that failed.
  Result<void> open(std::vector<std::string> files);
  /// Back to the first file; opens it.
  Result<void> rewind();
  /// Reads at most one piece. kStep filled `step`; kNextFile: what follows is of the next file.
  Result<Got> next(Step& step);

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
