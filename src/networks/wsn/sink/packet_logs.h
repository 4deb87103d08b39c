#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/scheduler.h"
#include "motes/packet_log.h"
#include "networks/wsn/sink/sink.h"
#include "transport/transports.h"

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

/// Appends the traffic of a sink to a packet log, in the format of the original's recorder (log.md 1). After a write
/// error it pauses for a minute and resumes with the next packet.
class PacketRecorder {
 public:
  static constexpr Duration kRetryPause = std::chrono::minutes(1);
  /// As SinkCallbacks::note; may be empty.
  using Note = std::function<void(const std::string& subject, std::string_view text)>;

  PacketRecorder(std::string path, Scheduler& scheduler, transport::Transports& transports, Note note);

  /// Opens the file and creates it if necessary; does nothing if it is open. kInvalid: the file is not a packet log; it
  /// stays unchanged. kBusy: another process writes it.
  Result<void> open();
  /// A packet that the sink sent.
  void read(ByteView packet) { record(motes::PacketDirection::kRead, packet); }
  /// A packet that was sent to the sink.
  void written(ByteView packet) { record(motes::PacketDirection::kWritten, packet); }
  /// Counters by name (`[a-z-]+`).
  std::map<std::string, std::uint64_t> counters() const;

 private:
  void record(motes::PacketDirection direction, ByteView packet);
  bool ready();
  void pause(const Error& why);

  std::string path_;
  Scheduler& scheduler_;
  transport::Transports& transports_;
  Note note_;
  std::unique_ptr<transport::AppendFile> file_;
  SteadyTime next_try_ = SteadyTime::min();
  std::uint64_t recorded_ = 0, unrecorded_ = 0, pauses_ = 0;
};

}  // namespace rubicon::networks::wsn::sink
