#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "base/result.h"

namespace rubicon::transport {

/// A file being read from front to back in pieces.
class FileSource {
 public:
  virtual ~FileSource() = default;
  /// Fills `into` from the present position; 0 = end of file. kIo on failure.
  virtual Result<std::size_t> read(std::span<std::uint8_t> into) = 0;
  virtual Result<void> seek(std::uint64_t offset) = 0;
  virtual std::uint64_t size() const = 0;
};

/// Everything through which bytes enter and leave the process. Networks get it from their host, so that tests can hand
/// them lines of memory. Later networks add their line here (UDP, TCP, serial), each with its twin.
class Transports {
 public:
  virtual ~Transports() = default;
  /// kNotFound or kIo with the path in the text; a directory is refused.
  virtual Result<std::unique_ptr<FileSource>> open_file(const std::string& path) = 0;
};

}  // namespace rubicon::transport
