#pragma once

#include <map>
#include <optional>
#include <set>

#include "base/bytes.h"
#include "support/memory/memory_serial.h"
#include "support/memory/memory_udp.h"
#include "transport/transports.h"

namespace rubicon::transport {

/// Replaces LocalTransports in tests: in-memory files that fail where a test wants. Must outlive the files that it
/// opened.
class MemoryTransports final : public Transports {
 public:
  struct File {
    Bytes bytes;
    std::optional<std::uint64_t> fails_at;  ///< reading this offset is an I/O error
    bool appending = false;                 ///< open for writing
    bool open_to_all = false;
  };

  void put(const std::string& path, Bytes bytes) { files_[path] = {std::move(bytes), std::nullopt, false, false}; }
  void put(const std::string& path, std::string_view text);
  void fail_at(const std::string& path, std::uint64_t offset) { files_[path].fails_at = offset; }
  void open_to_all(const std::string& path) { files_[path].open_to_all = true; }
  void remove(const std::string& path) { files_.erase(path); }

  /// Connects this host to a network under an address; the network must outlive it. Without one there are no sockets
  /// (kUnsupported) and no host names.
  void join(MemoryNet& net, std::string address = "127.0.0.1");

  /// The host's serial lines; there are none before join(): asserted.
  MemorySerial& serial();

  Result<std::unique_ptr<FileSource>> open_file(const std::string& path) override;
  Result<std::unique_ptr<UdpSocket>> open_udp(const UdpOptions& options, UdpCallbacks calls) override;
  Result<std::unique_ptr<TcpStream>> open_tcp(const TcpOptions& options, TcpCallbacks calls) override;
  Result<std::unique_ptr<TcpListener>> listen_tcp(const Endpoint& local, TcpAccept accept,
                                                  ListenerFailed failed = nullptr) override;
  Result<std::unique_ptr<ByteStream>> open_serial(const SerialOptions& options, StreamCallbacks calls) override;
  /// The device's end of a serial line called `link`.
  Result<std::unique_ptr<ByteStream>> make_pty(const std::string& link, StreamCallbacks calls) override;
  /// To an MqttBroker of the network.
  Result<std::unique_ptr<MqttLine>> open_mqtt(const MqttOptions& options, MqttCallbacks calls) override;
  std::unique_ptr<Lookup> look_up(const std::string& host, LookupDone done) override;

  /// Its jobs run in turns of the network's loop.
  Result<std::unique_ptr<Worker>> start_worker(const std::string& name) override;

  // Writing: all folders exist, but those that a test removes with lose_folder().
  Result<std::unique_ptr<AppendFile>> open_append(const std::string& path) override;
  Result<void> rename_file(const std::string& from, const std::string& to) override;
  Result<void> remove_file(const std::string& path) override;
  Result<std::vector<std::string>> list_folder(const std::string& path) override;

  /// Free space of the disk: a write beyond it fails after a part was written. nullopt = unlimited.
  void room(std::optional<std::uint64_t> bytes) { room_ = bytes; }
  /// Opening and renaming in this folder fails as if it did not exist.
  void lose_folder(const std::string& path) { lost_.insert(path); }
  void give_folder(const std::string& path) { lost_.erase(path); }
  /// Truncating files fails, as on a disk that has become read-only.
  void refuse_cuts(bool refuse) { cuts_refused_ = refuse; }
  void refuse_renames(bool refuse) { renames_refused_ = refuse; }
  bool has(const std::string& path) const { return files_.contains(path); }
  const Bytes& bytes(const std::string& path) { return files_[path].bytes; }
  std::vector<std::string> paths() const;

 private:
  class MemoryAppendFile;
  bool is_lost(const std::string& path) const;

  MemoryNet* net_ = nullptr;
  std::string address_;
  std::unique_ptr<MemorySerial> serial_;
  std::map<std::string, File> files_;
  std::optional<std::uint64_t> room_;
  std::set<std::string> lost_;
  bool cuts_refused_ = false;
  bool renames_refused_ = false;
};

}  // namespace rubicon::transport
