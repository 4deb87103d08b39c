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

/// Records what is read from a sink and written to it, as the original's recorder does (log.md 1), behind what the file
/// has already. When the file cannot be written it stops, and tries again with the first packet a minute later.
class PacketRecorder {
 public:
  static constexpr Duration kPause = std::chrono::minutes(1);
  /// As SinkCallbacks::note; may be empty.
  using Note = std::function<void(const std::string& subject, std::string_view text)>;

  PacketRecorder(std::string path, Scheduler& scheduler, transport::Transports& transports, Note note);

  /// Opens the file, makes it if it is not there; nothing if it is open. kInvalid for a file that is no packet log,
  /// which stays as it is; kBusy when somebody else writes it.
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
  void stop(const Error& why);

  std::string path_;
  Scheduler& scheduler_;
  transport::Transports& transports_;
  Note note_;
  std::unique_ptr<transport::AppendFile> file_;
  SteadyTime next_try_ = SteadyTime::min();
  std::uint64_t recorded_ = 0, unrecorded_ = 0, stops_ = 0;
};

}  // namespace rubicon::networks::wsn::sink
