#pragma once

#include <deque>

#include "apps/simulators/motes/sink_firmware.h"
#include "motes/hdlc.h"
#include "motes/mote_records.h"

namespace rubicon::motes_simulator {

struct ComputerOptions {
  std::uint16_t island = 11;
  std::uint16_t period = 1024;  ///< TinyOS milliseconds between two reports of a mote
  bool updates = false;         ///< asks for UPDATES instead of DEMO_DATA
};

/// A computer at a sink that does the least a computer can, for recordings without a proxy: it sets the island and
/// tells each mote that joins to report. Takes the sink's output; the sink outlives it.
class Computer {
 public:
  Computer(ComputerOptions options, SinkFirmware& sink, Scheduler& scheduler);
  ~Computer();
  Computer(const Computer&) = delete;
  Computer& operator=(const Computer&) = delete;

 private:
  static constexpr std::size_t kMaxWaiting = 1000;
  void received(ByteView bytes);
  void on_packet(ByteView packet);
  void send(Bytes packet);
  void next();

  ComputerOptions options_;
  SinkFirmware& sink_;
  Scheduler& scheduler_;
  motes::HdlcReader reader_;
  std::deque<Bytes> waiting_;
  std::uint8_t serial_ = 0;
  std::uint16_t sequence_ = 0;
  Timer pause_;
};

}  // namespace rubicon::motes_simulator
