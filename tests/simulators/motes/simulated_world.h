#pragma once

#include "simulators/motes/simulated_sink.h"
#include "support/memory/memory_sinks.h"
#include "support/memory/memory_transports.h"

namespace rubicon::motes_simulator {

/// A computer that is connected to a sink's port.
struct Client {
  Client(transport::MemoryTransports& host, std::uint16_t port) {
    transport::TcpOptions options;
    options.remote = {"127.0.0.1", port};
    stream = host.open_tcp(options, {[this] { ++connected; },
                                     [this](ByteView bytes) {
                                       all += bytes.size();
                                       while (auto frame = reader.next(bytes)) ++frames;
                                     },
                                     [this](const Error&) { ++failed; }})
                 .value();
  }
  std::unique_ptr<transport::TcpStream> stream;
  motes::HdlcReader reader;
  std::size_t all = 0;
  int connected = 0, failed = 0, frames = 0;
};

/// Worlds whose sinks have ports on a network of memory: 19202, 19203, ...
class SimulatedWorld : public SimulatedSink {
 protected:
  SimulatedWorld() { host.join(net); }
  ~SimulatedWorld() override { world.reset(); }  // before the network it is on
  void open(WorldOptions options, std::string_view script = "") {
    make(std::move(options), script, false);
    for (std::uint16_t sink = 1; sink <= world->sinks(); ++sink)
      ASSERT_TRUE(world->open(sink, on_memory(net.tcp, {"127.0.0.1", static_cast<std::uint16_t>(19201 + sink)})));
  }
  /// A reliable message to the sink itself: it is acknowledged by the line and by the application.
  static Bytes probe_of_sink() {
    const auto record = hex("00");
    return motes::hdlc_acked_packet(9, motes::packet_of(command(1, record, 1, 1)));
  }
  /// As often as the sink reported it.
  std::size_t listed(std::uint16_t mote, std::uint16_t sink) const {
    return static_cast<std::size_t>(std::count_if(events.begin(), events.end(), [&](const Event& event) {
      return event.what == "listed" && event.mote == mote && event.sink == sink;
    }));
  }

  transport::MemoryNet net{time};
  transport::MemoryTransports host;
};

}  // namespace rubicon::motes_simulator
