#include "networks/wsn/sink/packet_recorder.h"

#include <fmt/format.h>

#include <array>
#include <utility>

namespace rubicon::networks::wsn::sink {

namespace {

/// Bytes that check_packet_log() needs.
constexpr std::size_t kBeginning = 32;

Result<Bytes> beginning_of(transport::Transports& transports, const std::string& path) {
  auto file = transports.open_file(path);
  if (!file) return fail(file.error());
  Bytes bytes(kBeginning);
  std::size_t size = 0;
  while (size < bytes.size()) {
    const auto count = (*file)->read(std::span(bytes).subspan(size));
    if (!count) return fail(count.error());
    if (*count == 0) break;
    size += *count;
  }
  bytes.resize(size);
  return bytes;
}

}  // namespace

PacketRecorder::PacketRecorder(std::string path, Scheduler& scheduler, transport::Transports& transports, Note note)
    : path_(std::move(path)), scheduler_(scheduler), transports_(transports), note_(std::move(note)) {}

Result<void> PacketRecorder::open() {
  if (file_) return {};
  auto file = transports_.open_append(path_);
  if (!file) return fail(file.error());
  const auto beginning = beginning_of(transports_, path_);
  if (!beginning) return fail(beginning.error());
  if (auto valid = motes::check_packet_log(*beginning); !valid)
    return fail(valid.error().code, fmt::format("{}: {}", path_, valid.error().text));
  file_ = std::move(*file);
  return {};
}

void PacketRecorder::record(motes::PacketDirection direction, ByteView packet) {
  const auto time = std::chrono::floor<std::chrono::milliseconds>(scheduler_.wall_now().time_since_epoch());
  const auto bytes = motes::packet_log_record(time, direction, packet);
  if (!bytes || !ready()) {
    ++unrecorded_;
    return;
  }
  const auto size = file_->size();
  if (auto done = file_->append(*bytes); !done) {
    ++unrecorded_;
    (void)file_->truncate(size);  // if this fails too, readers skip the partial record
    return pause(done.error());
  }
  ++recorded_;
}

bool PacketRecorder::ready() {
  if (file_) return true;
  if (scheduler_.now() < next_try_) return false;
  if (auto opened = open(); !opened) {
    pause(opened.error());
    return false;
  }
  return true;
}

void PacketRecorder::pause(const Error& why) {
  file_.reset();
  ++pauses_;
  next_try_ = scheduler_.now() + kRetryPause;
  if (note_) note_("recording-stops", fmt::format("recording pauses for a minute: {}", why.text));
}

std::map<std::string, std::uint64_t> PacketRecorder::counters() const {
  return {{"recorded", recorded_}, {"unrecorded", unrecorded_}, {"recording-stops", pauses_}};
}

}  // namespace rubicon::networks::wsn::sink
