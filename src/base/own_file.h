#pragma once

#include <string>

#include "rubicon/result.hpp"

namespace rubicon::base {

/// A file descriptor that is closed with its owner.
class OwnFile {
 public:
  OwnFile() = default;
  OwnFile(OwnFile&& other) noexcept;
  OwnFile& operator=(OwnFile&& other) noexcept;
  OwnFile(const OwnFile&) = delete;
  OwnFile& operator=(const OwnFile&) = delete;
  ~OwnFile();

  /// Opens a file that we write, and makes it if it is not there: readable for its user and group only (0640, whatever
  /// the umask allows), and never through a symbolic link, by which somebody else would choose what we overwrite.
  /// `flags` are those of open(2) beside O_CREAT. A file of ours that others may use, as earlier releases made them, is
  /// closed to them. kRefused: we may not; kNotFound: its folder is absent; kInvalid: it is a symbolic link; kIo:
  /// anything else, in the words of the system.
  static Result<OwnFile> open(const std::string& path, int flags);
  /// Does only the latter, to a file that somebody else opens and which may be absent.
  static void close_to_others(const std::string& path);

  int get() const { return descriptor_; }
  /// The descriptor, which the caller closes.
  int release();
  /// All of it, or kIo.
  Result<void> write(std::string_view bytes, const std::string& path) const;

 private:
  explicit OwnFile(int descriptor) : descriptor_(descriptor) {}
  int descriptor_ = -1;
};

}  // namespace rubicon::base

namespace rubicon {
using base::OwnFile;
}  // namespace rubicon
