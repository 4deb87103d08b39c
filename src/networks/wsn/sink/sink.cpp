#include "networks/wsn/sink/sink.h"

#include <chrono>
#include <utility>

#include "networks/wsn/sink/file_sink.h"
#include "networks/wsn/sink/forwarder_sink.h"
#include "networks/wsn/sink/serial_sink.h"

namespace rubicon::networks::wsn::sink {

namespace {

/// Differs from start to start, so that a late acknowledgement to an earlier process does not match.
std::uint8_t start_sequence(const Scheduler& scheduler) {
  const auto time = std::chrono::floor<std::chrono::milliseconds>(scheduler.wall_now().time_since_epoch());
  return static_cast<std::uint8_t>(static_cast<std::uint64_t>(time.count()) & 0xffU);
}

}  // namespace

std::unique_ptr<Sink> make_sink(SinkOptions options, Scheduler& scheduler, transport::Transports& transports,
                                SinkCallbacks callbacks) {
  switch (options.source.kind) {
    case Source::Kind::kForwarder:
      return std::make_unique<ForwarderSink>(std::move(options), scheduler, transports, std::move(callbacks));
    case Source::Kind::kFile:
      return std::make_unique<FileSink>(std::move(options), scheduler, transports, std::move(callbacks));
    case Source::Kind::kSerial:
    case Source::Kind::kStream: break;
  }
  return std::make_unique<SerialSink>(options, scheduler, transports, std::move(callbacks), start_sequence(scheduler));
}

}  // namespace rubicon::networks::wsn::sink
