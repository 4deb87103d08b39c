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

  /// Opens a file for writing, and creates it if it does not exist: accessible to its user and group only (0640,
  /// whatever the umask allows), and never through a symbolic link, which another user could point at a file to
  /// overwrite. `flags` are those of open(2) besides O_CREAT. Takes away access by others that earlier releases gave.
  /// kRefused: no permission; kNotFound: the folder does not exist; kInvalid: it is a symbolic link; kIo: other errors
  /// of the system.
  static Result<OwnFile> open(const std::string& path, int flags);
  /// Takes over a descriptor that the system gave; a negative one is not a file.
  static OwnFile of_descriptor(int descriptor) { return OwnFile(descriptor); }
  /// Only takes away access by others, from a file that need not exist.
  static void close_to_others(const std::string& path);

  int get() const { return descriptor_; }
  /// The descriptor, which the caller closes.
  int release();
  /// Writes all of it; kIo on failure.
  Result<void> write(std::string_view bytes, const std::string& path) const;

 private:
  explicit OwnFile(int descriptor) : descriptor_(descriptor) {}
  int descriptor_ = -1;
};

}  // namespace rubicon::base

namespace rubicon {

using base::OwnFile;

}  // namespace rubicon

namespace rubicon::base {

/// The path from the root, as programs in other folders find the file; without `.` and `..`.
std::string whole_path(const std::string& path);

}  // namespace rubicon::base
