#pragma once

#include <map>
#include <optional>

#include "base/bytes.h"
#include "transport/memory_udp.h"
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

  /// Puts this host on a network under an address; the network must outlive it. Without one there are no sockets
  /// (kUnsupported) and no names.
  void join(MemoryNet& net, std::string address = "127.0.0.1");

  Result<std::unique_ptr<FileSource>> open_file(const std::string& path) override;
  Result<std::unique_ptr<UdpSocket>> open_udp(const UdpOptions& options, UdpCalls calls) override;
  std::unique_ptr<Lookup> look_up(const std::string& host, LookupDone done) override;

 private:
  MemoryNet* net_ = nullptr;
  std::string address_;
  std::map<std::string, File> files_;
};

}  // namespace rubicon::transport
