#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "motes/packet_log_reader.h"
#include "networks/wsn/sink/sink_notifier.h"

namespace rubicon::networks::wsn::sink {

/// Plays a packet log at its recorded pace, starting with the first open() (Source::Kind kFile; log.md 1.2): only the
/// packets that the sink sent. After a failure open() continues where it stopped. Takes no packets.
class FileSink final : public Sink {
 public:
  /// Longer gaps between two records are shortened to this.
  static constexpr Duration kMaxGap = std::chrono::hours(1);

  FileSink(SinkOptions options, Scheduler& scheduler, transport::Transports& transports, SinkCallbacks callbacks);
  FileSink(const FileSink&) = delete;
  FileSink& operator=(const FileSink&) = delete;

  Result<void> open() override;
  /// Always kRefused.
  Result<void> send(Outgoing packet) override;
  const SinkState& state() const override { return notifier_.state(); }
  std::map<std::string, std::uint64_t> counters() const override;

 private:
  void play();
  bool read_piece();
  bool damaged(const motes::Damage& damage);
  void schedule(const motes::PacketRecord& record);

  std::string path_;
  Scheduler& scheduler_;
  transport::Transports& transports_;
  SinkNotifier notifier_;
  std::unique_ptr<transport::FileSource> file_;
  motes::PacketLogReader reader_;
  std::uint64_t read_ = 0;  ///< bytes of the file
  std::vector<std::uint8_t> piece_;
  std::optional<motes::PacketRecord> next_;
  std::optional<std::chrono::milliseconds> previous_;  ///< recorded time of the record before `next_`
  SteadyTime due_{};                                   ///< of `next_`; while there is none, of the record before it
  std::uint64_t damaged_ = 0, skipped_bytes_ = 0;
  Timer timer_;
};

}  // namespace rubicon::networks::wsn::sink
