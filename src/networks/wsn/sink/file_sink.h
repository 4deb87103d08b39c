#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "motes/packet_log_reader.h"
#include "networks/wsn/sink/sink_notifier.h"

namespace rubicon::networks::wsn::sink {

/// A packet log, played at its own pace from the first open() on (Source::Kind kFile; log.md 1.2): only what the sink
/// said. After a failure open() goes on where it failed. Takes no packets.
class FileSink final : public Sink {
 public:
  static constexpr Duration kLongestGap = std::chrono::hours(1);

  FileSink(SinkOptions options, Scheduler& scheduler, transport::Transports& transports, SinkCallbacks calls);
  FileSink(const FileSink&) = delete;
  FileSink& operator=(const FileSink&) = delete;

  Result<void> open() override;
  /// kRefused.
  Result<void> send(Outgoing packet) override;
  const SinkState& state() const override { return notifier_.state(); }
  std::map<std::string, std::uint64_t> counters() const override;

 private:
  void go_on();
  bool next_piece();
  bool damaged(const motes::Damage& damage);
  void plan(const motes::PacketRecord& record);

  std::string path_;
  Scheduler& scheduler_;
  transport::Transports& transports_;
  SinkNotifier notifier_;
  std::unique_ptr<transport::FileSource> file_;
  motes::PacketLogReader reader_;
  std::uint64_t read_ = 0;  ///< bytes of the file
  std::vector<std::uint8_t> piece_;
  std::optional<motes::PacketRecord> next_;
  std::optional<std::chrono::milliseconds> last_;  ///< time written in the record before
  SteadyTime due_{};                               ///< of that record, then of the next one
  std::uint64_t damaged_ = 0, skipped_bytes_ = 0;
  Timer timer_;
};

}  // namespace rubicon::networks::wsn::sink
