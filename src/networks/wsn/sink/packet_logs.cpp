#include "networks/wsn/sink/packet_logs.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

namespace rubicon::networks::wsn::sink {

namespace {

using Phase = SinkState::Phase;

/// Bytes read in one turn of the loop.
constexpr std::size_t kPiece = std::size_t{4} * 1024;

/// Zero if the recording's clock was set back (log.md 1.2). The times come from a file: a plain difference may
/// overflow.
Duration gap_between(std::chrono::milliseconds from, std::chrono::milliseconds to) {
  if (to <= from) return Duration::zero();
  const auto gap = static_cast<std::uint64_t>(to.count()) - static_cast<std::uint64_t>(from.count());
  constexpr auto kMax = std::chrono::duration_cast<std::chrono::milliseconds>(FileSink::kMaxGap).count();
  return std::chrono::milliseconds(std::min<std::uint64_t>(gap, kMax));
}

}  // namespace

FileSink::FileSink(SinkOptions options, Scheduler& scheduler, transport::Transports& transports,
                   SinkCallbacks callbacks)
    : path_(std::move(options.source.path)),
      scheduler_(scheduler),
      transports_(transports),
      notifier_(std::move(callbacks)),
      piece_(kPiece) {}

Result<void> FileSink::open() {
  if (notifier_.state().phase != Phase::kOff) return {};
  auto file = transports_.open_file(path_);
  if (!file) return fail(file.error());
  if (auto there = (*file)->seek(read_); !there) return there;
  file_ = std::move(*file);
  due_ = scheduler_.now();  // the time of a failure is not caught up
  notifier_.connecting();
  timer_ = scheduler_.after(Duration::zero(), [this] {
    if (notifier_.set_state(Phase::kUp, {})) play();
  });
  return {};
}

Result<void> FileSink::send(Outgoing) {  // NOLINT(performance-unnecessary-value-param)
  return fail(ErrorCode::kRefused, "a recording takes no packets: recorded motes cannot be commanded");
}

/// Delivers the record that is due, if there is one, and schedules the next: one record or one piece of the file a
/// turn.
void FileSink::play() {
  if (const auto record = std::exchange(next_, std::nullopt)) {
    if (!notifier_.received(record->packet)) return;
  }
  while (auto item = reader_.next()) {
    if (const auto* damage = std::get_if<motes::Damage>(&*item)) {
      if (!damaged(*damage)) return;
    } else if (auto& record = std::get<motes::PacketRecord>(*item); record.from_sink) {
      schedule(record);
      next_ = std::move(record);
      return;
    }
  }
  if (read_piece()) timer_ = scheduler_.after(Duration::zero(), [this] { play(); });
}

/// False: there is none, or this was destroyed.
bool FileSink::read_piece() {
  if (!file_) {
    (void)notifier_.set_state(Phase::kEnded, "the recording has ended");
    return false;
  }
  const auto count = file_->read(piece_);
  if (!count) {
    file_.reset();
    (void)notifier_.failed(count.error());
    return false;
  }
  read_ += *count;
  if (*count > 0) {
    reader_.feed(ByteView(piece_).first(*count));
  } else {
    reader_.end();
    file_.reset();
  }
  return true;
}

bool FileSink::damaged(const motes::Damage& damage) {
  ++damaged_;
  skipped_bytes_ += damage.bytes;
  return notifier_.note(
      "damaged", fmt::format("{}: offset {}: {}; {} bytes skipped", path_, damage.offset, damage.why, damage.bytes));
}

/// Counts from when the previous record was due, so that delays do not accumulate.
void FileSink::schedule(const motes::PacketRecord& record) {
  if (previous_) due_ += gap_between(*previous_, record.time);
  previous_ = record.time;
  timer_ = scheduler_.at(due_, [this] { play(); });
}

std::map<std::string, std::uint64_t> FileSink::counters() const {
  std::map<std::string, std::uint64_t> counters;
  notifier_.count(counters);
  counters["damaged"] = damaged_;
  counters["skipped-bytes"] = skipped_bytes_;
  return counters;
}

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
