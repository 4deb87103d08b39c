#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "base/scheduler.h"
#include "transport/serial.h"
#include "transport/stream.h"

namespace rubicon::transport {

/// The serial lines of a host of memory (MemoryTransports::serial()): devices by plug(), programs by
/// MemoryTransports::open_serial. Outlives the streams.
class MemorySerial {
 public:
  explicit MemorySerial(Scheduler& scheduler);
  ~MemorySerial();
  MemorySerial(const MemorySerial&) = delete;
  MemorySerial& operator=(const MemorySerial&) = delete;

  /// The device's end of a new line; destroyed = unplugged, and the path is gone until somebody plugs again. It does
  /// not notice who opens and closes the path; what it sends meanwhile is lost. Nothing may be plugged there: asserted.
  std::unique_ptr<ByteStream> plug(const std::string& path, StreamCalls calls);
  bool is_plugged(const std::string& path) const { return devices_.contains(path); }
  /// How the path was opened; nullptr if nobody has it open.
  const SerialOptions* opened(const std::string& path) const;

  Duration transit = std::chrono::microseconds(100);  ///< of each piece
  std::size_t segment = 0;  ///< bytes arrive in pieces of so many; 0 = what was sent in a turn is one piece

  /// As Transports::open_serial.
  Result<std::unique_ptr<ByteStream>> open(const SerialOptions& options, StreamCalls calls);

 private:
  friend class MemoryLine;
  struct End;
  using EndPtr = std::shared_ptr<End>;

  std::unique_ptr<ByteStream> make(const EndPtr& end, StreamCalls calls);
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
