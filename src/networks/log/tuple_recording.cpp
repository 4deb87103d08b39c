#include "networks/log/tuple_recording.h"

#include <algorithm>
#include <utility>

#include "recording/recording_reader.h"

namespace rubicon::networks::log {

using recording::Record;

namespace {

/// Bytes that the reader may search without a result before it ends the turn.
constexpr std::size_t kReaderBudget = 4 << 20;
/// Records of the first block in which network names are searched; the recorder's own blocks have fewer.
constexpr std::size_t kLookAhead = 50'000;
/// As many as a processor fetches memory for at the same time.
constexpr std::size_t kAtOnce = 16;

}  // namespace

TupleRecording::TupleRecording(const TypeCatalogue& types, std::string network, ReplayCounters& counters,
                               Complaint complain)
    : counters_(counters),
      reader_(kReaderBudget),
      faults_(counters, std::move(complain), reader_),
      types_(types),
      keys_(std::move(network), types_, budget_, faults_),
      replay_(keys_, types_, budget_, faults_, step_) {}

void TupleRecording::begin(std::string_view, std::vector<std::string>) {
  reader_ = recording::RecordingReader(kReaderBudget);
  keys_.begin_block();
  put_back_.reset();
  behind_.reset();
  next_.clear();
  next_place_ = 0;
  left_in_block_ = 0;
}

bool TupleRecording::ready() const {
  if (failure_ || keys_.ambiguous()) return false;
  return keys_.chosen_by_user() ? head_read_ : first_block_read_;
}

std::vector<std::string> TupleRecording::devices() const {
  std::vector<std::string> joined;
  for (const auto& [id, device] : keys_.devices()) {
    if (device->joined()) joined.push_back(device->joined_as);
  }
  return joined;
}

/// A step holds what was seen in one turn of the recorded loop, or a part of it.
std::optional<Step> TupleRecording::next() {
  step_ = {};
  has_more_ = !read_on();
  if (!failure_ && !step_.messages.empty()) return std::move(step_);
  if (has_more_) budget_.renew();
  return std::nullopt;
}

/// True: there is nothing left to play; false: the step is complete, or the budget is used up.
bool TupleRecording::read_on() {
  while (!failure_) {
    if (keys_.ambiguous()) return read_network_names();
    if (!replay_.run_pending() || replay_.budget_used()) return false;
    const auto record = put_back_ ? std::exchange(put_back_, std::nullopt) : next_record();
    if (!record) {
      if (reader_.busy() || replay_.budget_used()) return false;
      if (!reader_.ended() || !replay_.has_deferred()) return true;
      replay_.end_turn();
    } else if (replay_.must_end_turn_before(*record)) {
      replay_.end_turn();
      put_back_ = record;
    } else if (!belongs_to_step(*record)) {
      put_back_ = record;
      return false;
    } else {
      step_.time = record->seen.time_since_epoch();
      ++counters_.records;
      replay_.play(*record);
    }
  }
  return true;
}

bool TupleRecording::belongs_to_step(const Record& record) const {
  return step_.messages.empty() || step_.time == record.seen.time_since_epoch();
}

/// Reads to the end of the file, only for the names of the networks: one may appear late.
bool TupleRecording::read_network_names() {
  step_ = {};
  while (const auto record = next_record()) keys_.note_network(*record);
  if (reader_.busy() || replay_.budget_used()) return false;
  if (!reader_.ended()) return true;
  failure_ = keys_.networks().ambiguous();
  return true;
}

std::optional<Record> TupleRecording::next_record() {
  while (!failure_ && !budget_.used_up()) {
    if (must_read()) read_some();
    if (next_place_ < next_.size()) {
      const auto& record = next_[next_place_++];
      budget_.charge(1);
      budget_.charge_copied(record.value.size());
      return record;
    }
    if (!behind_) return std::nullopt;
    read(*std::exchange(behind_, std::nullopt));
  }
  return std::nullopt;
}

/// Some are looked up while those before them are played. What follows the last record of a block may end the life of
/// all before it.
bool TupleRecording::must_read() const {
  const auto left = next_.size() - next_place_;
  return !behind_ && (left == 0 || (left <= kAtOnce && left_in_block_ > 0));
}

void TupleRecording::read_some() {
  next_.erase(next_.begin(), next_.begin() + static_cast<std::ptrdiff_t>(std::exchange(next_place_, 0)));
  const auto before = next_.size();
  for (auto most = std::clamp<std::size_t>(left_in_block_, 1, kAtOnce); most > 0; --most) {
    auto item = reader_.next();
    if (!item) break;
    const auto* record = std::get_if<Record>(&*item);
    if (!record) {
      behind_ = std::move(item);
      break;
    }
    next_.push_back(*record);
  }
  const auto fresh = std::span(next_).subspan(before);
  left_in_block_ -= std::min(left_in_block_, static_cast<std::uint32_t>(fresh.size()));
  keys_.fetch(fresh);
}

void TupleRecording::read(const recording::RecordingReader::Item& item) {
  if (const auto* head = std::get_if<recording::FileHead>(&item)) read_head(*head);
  if (const auto* block = std::get_if<recording::BlockFound>(&item)) read_block_head(block->head);
  const auto* damage = std::get_if<recording::Damage>(&item);
  if (!damage) return;
  budget_.charge(1);
  budget_.charge_copied(static_cast<std::size_t>(damage->bytes));
  replay_.damaged();
  faults_.skipped(*damage);
}

void TupleRecording::read_head(const recording::FileHead& head) {
  budget_.charge(1);
  head_read_ = true;
  if (keys_.read_head(head)) return;
  faults_.foreign_file(fmt::format("is of island {}, the files before are of island {}; not played",
                                   number(head.island), number(keys_.island())));
}

void TupleRecording::read_block_head(const recording::BlockHead& head) {
  budget_.charge_copied(recording::kBlockSize);
  left_in_block_ = head.records;
  keys_.begin_block();
  head_read_ = true;  // or lost
  if (!std::exchange(first_block_read_, true) && !keys_.chosen_by_user()) note_networks_of_block();
}

/// A recorder begins with all tuples there are: the first block names the networks.
void TupleRecording::note_networks_of_block() {
  auto records = reader_.block();
  for (std::size_t i = 0; i < kLookAhead; ++i) {
    const auto record = records.next();
    if (!record) break;
    keys_.target_of(*record);
  }
  keys_.begin_block();
  budget_.charge_all();
}

std::optional<RecordTime> end_of_recording(transport::Transports& transports, const std::string& path) {
  const auto file = transports.open_file(path);
  if (!file) return std::nullopt;
  const auto read = [&file](std::uint64_t offset, std::span<std::uint8_t> into) -> Result<std::size_t> {
    if (auto there = (*file)->seek(offset); !there) return fail(there.error());
    return (*file)->read(into);
  };
  const auto tail = recording::find_tail((*file)->size(), read);
  if (!tail || !tail->last) return std::nullopt;
  return tail->last->time_since_epoch();
}

}  // namespace rubicon::networks::log
