#include "networks/wsn/sink/file_sink.h"

#include <fmt/format.h>

#include <algorithm>
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

}  // namespace rubicon::networks::wsn::sink
