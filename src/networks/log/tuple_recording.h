#pragma once

#include <optional>
#include <string>
#include <vector>

#include "networks/log/device_replay.h"
#include "networks/log/recorded_keys.h"
#include "networks/log/recording.h"
#include "networks/log/replay_clock.h"
#include "recording/recording_reader.h"
#include "transport/transports.h"

namespace rubicon::networks::log {

/// Recordings of our own (docs/recording-format.md): the tuples of one recorded network, as what its devices sent.
/// Bounded in memory, and in what one next() does, whatever the files hold.
class TupleRecording final : public Recording {
 public:
  /// `network`: which one; empty = the only one there is.
  TupleRecording(const TypeCatalogue& types, std::string network, ReplayCounters& counters, Complaint complain);

  void begin(std::string_view file_name, std::vector<std::string> labels) override;
  void restart() override { replay_.begin_session(); }
  void feed(ByteView bytes) override { reader_.feed(bytes); }
  void end() override { reader_.end(); }
  std::optional<Step> next() override;
  bool has_more() const override { return has_more_; }
  bool ready() const override;
  std::optional<Error> failure() const override { return failure_; }
  bool absolute_times() const override { return true; }
  bool has_user_times() const override { return true; }
  RecordTime period() const override { return RecordTime{0}; }
  std::vector<std::string> devices() const override;

 private:
  bool read_on();
  bool read_network_names();
  bool belongs_to_step(const recording::Record& record) const;
  std::optional<recording::Record> next_record();
  bool must_read() const;
  void read_some();
  void read(const recording::RecordingReader::Item& item);
  void read_head(const recording::FileHead& head);
  void read_block_head(const recording::BlockHead& head);
  void note_networks_of_block();

  ReplayCounters& counters_;
  recording::RecordingReader reader_;
  RecordingFaults faults_;
  WorkBudget budget_;
  ForeignTypes types_;
  Step step_;
  RecordedKeys keys_;
  DeviceReplay replay_;
  bool head_read_ = false;
  bool first_block_read_ = false;
  bool has_more_ = false;
  std::optional<Error> failure_;
  std::optional<recording::Record> put_back_;  ///< read, not yet played
  std::uint32_t left_in_block_ = 0;            ///< records of the present block that were not read yet
  /// The records of the present block that come next, and what follows them if it is no record.
  std::vector<recording::Record> next_;
  std::size_t next_place_ = 0;
  std::optional<recording::RecordingReader::Item> behind_;
};

/// The time of the last record of a recording of our own, found from the end of the file; nullopt where it cannot be
/// read, or has no sound block near its end.
std::optional<RecordTime> end_of_recording(transport::Transports& transports, const std::string& path);

}  // namespace rubicon::networks::log
