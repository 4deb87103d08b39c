#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/scheduler.h"
#include "motes/framing.h"
#include "networks/wsn/sink/send_queue.h"
#include "networks/wsn/sink/serial_link.h"
#include "networks/wsn/sink/sink.h"
#include "transport/transports.h"

namespace rubicon::networks::wsn::sink {

/// A TCP connection to a host name: resolves the name, then tries its addresses in order. Destroying it cancels or
/// closes the connection. The callbacks of any stream; each call may destroy the stream.
class HostStream final : public transport::ByteStream {
 public:
  /// kUnsupported where there are no sockets.
  static Result<std::unique_ptr<ByteStream>> open(const std::string& host, std::uint16_t port,
                                                  transport::Transports& transports, transport::StreamCallbacks calls);
  HostStream(std::string host, std::uint16_t port, transport::Transports& transports, transport::StreamCallbacks calls);
  ~HostStream() override;
  HostStream(const HostStream&) = delete;
  HostStream& operator=(const HostStream&) = delete;

  /// kUnreachable before it is connected.
  Result<void> send(ByteView bytes) override;
  void hold(bool held) override;
  std::size_t queued() const override { return tcp_ ? tcp_->queued() : 0; }

 private:
  void resolved(Result<std::vector<std::string>> addresses);
  void connect_next(Error why);
  void lost(Error why);
  void fail_with(Error why);

  std::string host_;
  std::uint16_t port_;
  transport::Transports& transports_;
  transport::StreamCallbacks callbacks_;
  std::unique_ptr<transport::Lookup> lookup_;
  std::vector<std::string> untried_;  ///< addresses, the next one last
  std::string address_;               ///< the last one tried
  std::unique_ptr<transport::TcpStream> tcp_;
  bool connected_ = false;
  bool held_ = false;
};

/// A sink on a serial line, or on the bytes of one over TCP (Source::Kind kSerial, kStream). Up after its first valid
/// frame; a sink that does not answer the greeting is a lost line. Without a greeting it is up when the line is.
class SerialSink final : public Sink {
 public:
  /// `first_sequence`: of the first frame; any value will do (wsn.md 2).
  SerialSink(const SinkOptions& options, Scheduler& scheduler, transport::Transports& transports,
             SinkCallbacks callbacks, std::uint8_t first_sequence);
  SerialSink(const SerialSink&) = delete;
  SerialSink& operator=(const SerialSink&) = delete;

  Result<void> open() override;
  Result<void> send(Outgoing packet) override { return queue_.push(std::move(packet)); }
  const SinkState& state() const override { return notifier_.state(); }
  std::map<std::string, std::uint64_t> counters() const override;

 private:
  Result<std::unique_ptr<transport::ByteStream>> open_line();
  SerialLink::Callbacks link_callbacks();
  void show_acknowledging(bool acknowledges);
  void lost(Error why);

  Source source_;
  transport::Transports& transports_;
  SinkNotifier notifier_;
  SendQueue queue_;
  std::unique_ptr<transport::ByteStream> line_;
  SerialLink link_;
  bool greets_;
};

/// A sink behind a serial forwarder (Source::Kind kForwarder; wsn.md 4): up after the forwarder's greeting. The
/// protocol does not carry the sink's acknowledgements: packets keep a minimum gap, and count as acknowledged when they
/// are written.
class ForwarderSink final : public Sink {
 public:
  static constexpr Duration kMinGap = std::chrono::milliseconds(100);  ///< between packets (wsn.md 9.7)
  static constexpr Duration kGreetingTimeout = std::chrono::seconds(10);

  ForwarderSink(SinkOptions options, Scheduler& scheduler, transport::Transports& transports, SinkCallbacks callbacks);
  ForwarderSink(const ForwarderSink&) = delete;
  ForwarderSink& operator=(const ForwarderSink&) = delete;

  Result<void> open() override;
  Result<void> send(Outgoing packet) override { return queue_.push(std::move(packet)); }
  const SinkState& state() const override { return notifier_.state(); }
  std::map<std::string, std::uint64_t> counters() const override;

 private:
  void connected();
  void take(ByteView bytes);
  bool greeted();
  void pump();
  bool may_send();
  void written(Outgoing packet);
  void lost(Error why);

  Source source_;
  Bytes greeting_;
  Scheduler& scheduler_;
  transport::Transports& transports_;
  SinkNotifier notifier_;
  SendQueue queue_;
  std::unique_ptr<transport::ByteStream> line_;
  motes::ForwarderReader reader_;
  bool greeting_pending_ = false;  ///< the first packet on this line was not sent yet
  SteadyTime next_send_ = SteadyTime::min();
  Timer gap_, greeting_timeout_;
  std::uint64_t written_ = 0;
  base::Lifetime lifetime_;
};

}  // namespace rubicon::networks::wsn::sink
