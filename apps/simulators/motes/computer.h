#pragma once

#include <deque>

#include "apps/simulators/motes/sink_firmware.h"
#include "motes/framing.h"
#include "motes/mote_records.h"

namespace rubicon::motes_simulator {

struct ComputerOptions {
  std::uint16_t island = 11;
  std::uint16_t period = 1024;  ///< TinyOS milliseconds (1/1024 s) between two reports of a mote
  bool updates = false;         ///< requests UPDATES instead of DEMO_DATA
};

/// A minimal computer for recordings without a proxy: sets the island id of the sink and commands each mote that joins
/// to report. Takes over the sink's output. Sink and scheduler must outlive it.
class Computer {
 public:
  Computer(ComputerOptions options, SinkFirmware& sink, Scheduler& scheduler);
  ~Computer();
  Computer(const Computer&) = delete;
  Computer& operator=(const Computer&) = delete;

 private:
  static constexpr std::size_t kMaxQueued = 1000;
  void received(ByteView bytes);
  void on_packet(ByteView packet);
  void send(Bytes packet);
  void next();

  ComputerOptions options_;
  SinkFirmware& sink_;
  Scheduler& scheduler_;
  motes::HdlcReader reader_;
  std::deque<Bytes> queue_;
  std::uint8_t serial_sequence_ = 0;
  std::uint16_t sequence_ = 0;
  Timer pause_;
};

}  // namespace rubicon::motes_simulator
