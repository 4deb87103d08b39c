#pragma once

#include <set>

#include "motes/mote_codec.h"
#include "motes/packet_log_reader.h"
#include "networks/log/recording.h"

namespace rubicon::networks::log {

/// The original recorder's packet logs (log.md 1): the packets that the sink received, as messages of motes.
class PacketRecording final : public Recording {
 public:
  PacketRecording(const TypeCatalogue& types, motes::Calibration calibration, ReplayCounters& counters,
                  Complaint complain);

  void begin(std::string_view file_name, std::vector<std::string> labels) override;
  void feed(ByteView bytes) override { reader_.feed(bytes); }
  void end() override { reader_.end(); }
  std::optional<Step> next() override;
  bool absolute_times() const override { return true; }
  RecordTime period() const override { return RecordTime{0}; }
  std::vector<std::string> devices() const override { return {devices_.begin(), devices_.end()}; }

 private:
  std::optional<Step> step_of(const motes::PacketRecord& record);

  motes::MoteCodec codec_;
  ReplayCounters& counters_;
  Complaint complain_;
  motes::PacketLogReader reader_;
  std::set<std::string> devices_;
};

}  // namespace rubicon::networks::log
