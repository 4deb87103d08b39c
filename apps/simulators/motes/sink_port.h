#pragma once

#include <functional>
#include <memory>
#include <string>

#include "apps/simulators/motes/event.h"
#include "apps/simulators/motes/sink_firmware.h"
#include "transport/memory/memory_tcp.h"
#include "transport/transports.h"

namespace rubicon::motes_simulator {

/// The socket that a sink's serial line ends in: one computer at a time, as on a real line; a second one is refused.
/// While nobody is there the sink runs on, and its bytes are lost. Sink and log outlive it.
class SinkPort {
 public:
  /// What makes the port reachable, until the returned thing is destroyed.
  using Opener = std::function<Result<std::shared_ptr<void>>(SinkPort& port)>;

  SinkPort(SinkFirmware& sink, const EventLog& log);
  ~SinkPort();
  SinkPort(const SinkPort&) = delete;
  SinkPort& operator=(const SinkPort&) = delete;

  /// Opens it, and again when it is plugged in after it was pulled out.
  Result<void> open(Opener opener);
  /// Whoever is there loses the connection, and nobody can come.
  void pull();
  /// Opens it as before, unless it is open.
  Result<void> plug();
  bool pulled() const { return !reachable_; }
  bool in_use() const { return stream_ != nullptr; }
  /// A computer has come.
  void on_connected(std::function<void()> connected) { connected_ = std::move(connected); }
  /// The system took the port away, and nobody can come until plug(); who is there stays.
  void on_closed(std::function<void()> closed) { closed_ = std::move(closed); }

  /// For openers: a computer's end of the line, taken unless there is one already.
  transport::StreamCalls take(std::unique_ptr<transport::ByteStream> stream);
  transport::StreamCalls calls();
  void attach(std::unique_ptr<transport::ByteStream> stream);
  void lost();
  void closed();

 private:
  void received(ByteView bytes);

  SinkFirmware& sink_;
  const EventLog& log_;
  Opener opener_;
  std::shared_ptr<void> reachable_;
  std::unique_ptr<transport::ByteStream> stream_;
  std::function<void()> connected_, closed_;
};

/// Listens on TCP. `bound` is told what was bound, for port 0.
SinkPort::Opener on_tcp(transport::Transports& transports, transport::Endpoint at,
                        std::function<void(const transport::Endpoint&)> bound = {});
/// Listens on a network of memory.
SinkPort::Opener on_memory(transport::MemoryTcp& net, transport::Endpoint at);
/// A pseudo-terminal under this name.
SinkPort::Opener on_pty(transport::Transports& transports, std::string link);

}  // namespace rubicon::motes_simulator
