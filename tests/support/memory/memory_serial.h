#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "base/scheduler.h"
#include "transport/sockets.h"

namespace rubicon::transport {

/// The serial lines of an in-memory host (MemoryTransports::serial()): devices use plug(), programs
/// MemoryTransports::open_serial(). Must outlive the streams.
class MemorySerial {
 public:
  explicit MemorySerial(Scheduler& scheduler);
  ~MemorySerial();
  MemorySerial(const MemorySerial&) = delete;
  MemorySerial& operator=(const MemorySerial&) = delete;

  /// Returns the device's end of a new line; destroying it unplugs the device, and the path no longer exists. It does
  /// not notice opening and closing of the path; bytes sent while it is closed are lost. The path must be free:
  /// asserted.
  std::unique_ptr<ByteStream> plug(const std::string& path, StreamCallbacks calls);
  bool is_plugged(const std::string& path) const { return devices_.contains(path); }
  /// The options with which the path was opened; nullptr if it is not open.
  const SerialOptions* opened(const std::string& path) const;

  Duration transit = std::chrono::microseconds(100);  ///< of each piece
  std::size_t segment = 0;  ///< size of the pieces in which bytes arrive; 0 = one piece per turn

  /// As Transports::open_serial.
  Result<std::unique_ptr<ByteStream>> open(const SerialOptions& options, StreamCallbacks calls);

 private:
  friend class MemoryLine;
  struct End;
  using EndPtr = std::shared_ptr<End>;

  std::unique_ptr<ByteStream> make(const EndPtr& end, StreamCallbacks calls);
  Result<void> send(const EndPtr& end, ByteView bytes);
  void hold(const EndPtr& end, bool held);
  void flush(const EndPtr& end);
  void close(const EndPtr& end);
  void lose(const EndPtr& end);

  Scheduler& scheduler_;
  std::map<std::string, EndPtr> devices_;
  std::map<std::uint64_t, Timer> flights_;
  std::uint64_t last_flight_ = 0;
};

}  // namespace rubicon::transport
