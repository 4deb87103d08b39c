#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "base/scheduler.h"
#include "motes/packet_log_writer.h"
#include "transport/transports.h"

namespace rubicon::networks::wsn::sink {

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
