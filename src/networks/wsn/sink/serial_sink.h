#pragma once

#include <memory>

#include "networks/wsn/sink/serial_link.h"

namespace rubicon::networks::wsn::sink {

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

}  // namespace rubicon::networks::wsn::sink
