#pragma once

#include <set>

#include "motes/mote_codec.h"
#include "motes/packet_log.h"
#include "networks/log/csv_mapping.h"
#include "networks/log/file_chain.h"
#include "networks/log/recording.h"

namespace rubicon::networks::log {

/// Text tables (log.md 2). Each row becomes one message for each device that has a value in it.
class CsvRecording final : public Recording {
 public:
  CsvRecording(CsvMapping mapping, ReplayCounters& counters, Complaint complain);

  void begin(std::string_view file_name, std::vector<std::string> labels) override;
  void feed(ByteView bytes) override { reader_.feed(bytes); }
  void end() override { reader_.end(); }
  std::optional<Step> next() override;
  bool absolute_times() const override;
  RecordTime period() const override { return mapping_.period; }
  std::vector<std::string> label_tables() const override;
  std::vector<std::string> devices() const override;

 private:
  /// A mapped column that the present file has.
  struct FoundColumn {
    std::size_t cell;
    const ColumnMapping* mapping;
  };

  std::optional<Step> on_line(const TextLine& line);
  bool on_comment(std::string_view text);
  void on_names(std::string_view text, std::uint64_t offset);
  void find_columns(const std::vector<std::string>& names, std::uint64_t offset);
  std::optional<Step> row(const TextLine& line);
  std::optional<Step> damaged(const TextLine& line, std::string_view what);
  std::optional<RecordTime> row_time();
  void read_cells(const TextLine& line, std::size_t device, Step& step);
  void add_joins_and_properties(Step& step);
  model::Join join_of(const DeviceMapping& device) const;
  model::Updates properties_of(const DeviceMapping& device, std::size_t& label);

  CsvMapping mapping_;
  ReplayCounters& counters_;
  Complaint complain_;
  LineReader reader_;
  std::vector<std::vector<FoundColumn>> columns_;  ///< by device
  std::vector<std::string> labels_;
  std::map<std::string, std::string> comments_;
  std::vector<std::string_view> cells_;
  std::optional<std::size_t> time_cell_;
  std::size_t header_left_ = 0;
  std::uint64_t row_number_ = 0;
  std::optional<RecordTime> previous_;  ///< time of the row before
  bool names_known_ = false;
  bool described_ = false;  ///< joins and properties of the present file were played
  bool joined_ = false;     ///< in any file
};

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
