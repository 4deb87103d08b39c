#pragma once

#include <functional>
#include <memory>
#include <string>

#include "apps/simulators/motes/event.h"
#include "apps/simulators/motes/sink_firmware.h"
#include "transport/sockets.h"
#include "transport/transports.h"

namespace rubicon::motes_simulator {

/// The end of a sink's serial line: one computer at a time, as on a real line; a second one is refused. While no
/// computer is connected, the sink runs and its bytes are lost. Sink and log must outlive it.
class SinkPort {
 public:
  /// Makes the port reachable until the result is destroyed.
  using Opener = std::function<Result<std::shared_ptr<void>>(SinkPort& port)>;

  SinkPort(SinkFirmware& sink, const EventLog& log);
  ~SinkPort();
  SinkPort(const SinkPort&) = delete;
  SinkPort& operator=(const SinkPort&) = delete;

  /// Opens the port with `opener`, which plug() uses too.
  Result<void> open(Opener opener);
  /// Disconnects the computer and closes the port.
  void pull();
  /// Opens the port again if it is closed.
  Result<void> plug();
  bool pulled() const { return !reachable_; }
  bool in_use() const { return stream_ != nullptr; }
  /// Called when a computer connects.
  void on_connected(std::function<void()> connected) { connected_ = std::move(connected); }
  /// Called when the system closed the port: no computer can connect until plug(); a connected one stays.
  void on_closed(std::function<void()> closed) { closed_ = std::move(closed); }

  // For openers.

  /// Connects a computer unless there is one already.
  transport::StreamCallbacks take(std::unique_ptr<transport::ByteStream> stream);
  transport::StreamCallbacks calls();
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

/// Listens on TCP. `bound` gets the real address, for port 0.
SinkPort::Opener on_tcp(transport::Transports& transports, transport::Endpoint at,
                        std::function<void(const transport::Endpoint&)> bound = {});
/// Makes a pseudo-terminal with this name.
SinkPort::Opener on_pty(transport::Transports& transports, std::string link);

}  // namespace rubicon::motes_simulator
