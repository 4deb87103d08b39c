#include "networks/wsn/sink/sink.h"

#include <chrono>
#include <utility>

#include "networks/wsn/sink/file_sink.h"
#include "networks/wsn/sink/forwarder_sink.h"
#include "networks/wsn/sink/serial_sink.h"

namespace rubicon::networks::wsn::sink {

namespace {

/// Another one at each start, so that no ack of an earlier life is taken for ours.
std::uint8_t any_sequence(const Scheduler& scheduler) {
  const auto time = std::chrono::floor<std::chrono::milliseconds>(scheduler.wall_now().time_since_epoch());
  return static_cast<std::uint8_t>(static_cast<std::uint64_t>(time.count()) & 0xffU);
}

}  // namespace

std::unique_ptr<Sink> make_sink(SinkOptions options, Scheduler& scheduler, transport::Transports& transports,
                                SinkCallbacks calls) {
  switch (options.source.kind) {
    case Source::Kind::kForwarder:
      return std::make_unique<ForwarderSink>(std::move(options), scheduler, transports, std::move(calls));
    case Source::Kind::kFile:
      return std::make_unique<FileSink>(std::move(options), scheduler, transports, std::move(calls));
    case Source::Kind::kSerial:
    case Source::Kind::kStream: break;
  }
  return std::make_unique<SerialSink>(options, scheduler, transports, std::move(calls), any_sequence(scheduler));
}

}  // namespace rubicon::networks::wsn::sink
