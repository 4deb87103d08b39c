#include "networks/knx/secure/sequences.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "networks/knx/secure/secured_apdu.h"

namespace rubicon::networks::knx::secure {

namespace {

constexpr std::string_view kOwnName = "secure.sequence";
constexpr std::size_t kOwnSize = 8, kSenderSize = 7;
/// Sequence numbers of devices count from here where nothing is stored.
constexpr std::chrono::sys_days kEpoch = std::chrono::year{2018} / 1 / 5;

/// No host runs this program earlier.
constexpr std::chrono::sys_days kMinWallTime = std::chrono::year{2025} / 1 / 1;

std::uint64_t milliseconds_since_epoch(WallTime now) {
  const auto passed = std::chrono::duration_cast<std::chrono::milliseconds>(now - kEpoch).count();
  return passed > 0 ? static_cast<std::uint64_t>(passed) : 0;
}

Result<std::optional<Bytes>> read(const GroupStorage& storage, std::string_view name) {
  if (!storage.stored || !storage.store)
    return fail(ErrorCode::kUnsupported, "nothing is kept across restarts: there is no state file");
  return storage.stored(name);
}

std::string senders_name(std::uint8_t line) {
  return fmt::format("secure.senders-{}.{}", line >> 4, line & 0xf);
}

}  // namespace

// OwnSequence.

OwnSequence::OwnSequence(Scheduler& scheduler, GroupStorage storage, std::uint64_t known)
    : scheduler_(scheduler), storage_(std::move(storage)), next_(known + 1) {
  (void)load();
}

Result<void> OwnSequence::load() {
  if (loaded_) return {};
  const auto stored = read(storage_, kOwnName);
  if (!stored) {
    return fail(stored.error().code,
                fmt::format("its sequence number cannot be kept across restarts ({})", stored.error().text));
  }
  if (stored->has_value()) {
    base::ByteReader reader(**stored);
    const auto last = reader.u64_be();
    if ((*stored)->size() != kOwnSize || last > kMaxSequence)
      return fail(ErrorCode::kInvalid, "the stored sequence number cannot be read (secure.sequence)");
    next_ = std::max(next_, last + 1);
  }
  loaded_ = true;
  return {};
}

Result<void> OwnSequence::usable() {
  if (auto loaded = load(); !loaded) return loaded;
  if (next_ > 1 || scheduler_.wall_now() >= kMinWallTime) return {};
  return fail(ErrorCode::kRefused,
              "the clock of this host was never set, and no earlier sequence number is known: devices would ignore the "
              "telegrams");
}

Result<void> OwnSequence::reserve() {
  const auto first = std::max(next_, milliseconds_since_epoch(scheduler_.wall_now()));
  if (first > kMaxSequence) return fail(ErrorCode::kOutOfRange, "all sequence numbers are used");
  const auto limit = std::min(first + kReserve - 1, kMaxSequence);
  base::ByteWriter value;
  value.u64_be(limit);
  if (auto stored = storage_.store(kOwnName, value.view()); !stored)
    return fail(stored.error().code, fmt::format("its sequence number cannot be stored ({})", stored.error().text));
  next_ = first;
  limit_ = limit;
  return {};
}

Result<std::uint64_t> OwnSequence::next() {
  if (auto can = usable(); !can) return fail(can.error());
  if (next_ > limit_ || milliseconds_since_epoch(scheduler_.wall_now()) > limit_ + kAhead) {
    if (auto reserved = reserve(); !reserved) return fail(reserved.error());
  }
  return next_++;
}

// SenderSequences.

SenderSequences::SenderSequences(Scheduler& scheduler, GroupStorage storage,
                                 std::map<wire::IndividualAddress, std::uint64_t> start, Note note)
    : storage_(std::move(storage)),
      last_(std::move(start)),
      note_(std::move(note)),
      write_later_(scheduler, kPause, [this] { write(); }),
      sync_later_(scheduler, kSyncPause, [this] { sync(); }) {
  std::set<std::uint8_t> lines;
  for (const auto& [sender, last] : last_) lines.insert(line_of(sender));
  for (const auto line : lines) {
    if (auto done = load(line); !done) this->note(done.error().text);
  }
}

SenderSequences::~SenderSequences() {
  write();
}

void SenderSequences::note(std::string_view text) {
  if (note_) note_("data-secure-storage", text);
}

Result<void> SenderSequences::load(std::uint8_t line) {
  if (loaded_.contains(line)) return {};
  const auto stored = read(storage_, senders_name(line));
  if (!stored && stored.error().code != ErrorCode::kUnsupported)
    return fail(stored.error().code,
                fmt::format("the last sequence numbers of senders cannot be read: {}", stored.error().text));
  loaded_.insert(line);
  if (stored && stored->has_value()) take(line, **stored);
  return {};
}

void SenderSequences::take(std::uint8_t line, ByteView stored) {
  if (stored.size() % kSenderSize != 0)
    return note(fmt::format("the stored sequence numbers of {} are damaged and ignored", senders_name(line)));
  for (std::size_t at = 0; at < stored.size(); at += kSenderSize) {
    std::uint64_t sequence = 0;
    for (const auto byte : stored.subspan(at + 1, kSenderSize - 1)) sequence = sequence << 8U | byte;
    auto& last = last_[wire::IndividualAddress(static_cast<std::uint16_t>(line << 8U | stored[at]))];
    last = std::max(last, sequence);
  }
}

Result<std::uint64_t> SenderSequences::last(wire::IndividualAddress sender) {
  if (auto done = load(line_of(sender)); !done) return fail(done.error());
  const auto found = last_.find(sender);
  return found == last_.end() ? 0 : found->second;
}

void SenderSequences::set(wire::IndividualAddress sender, std::uint64_t sequence) {
  last_[sender] = sequence;
  changed_.insert(line_of(sender));
  write_later_.request();
}

Bytes SenderSequences::row_of(std::uint8_t line) const {
  base::ByteWriter row;
  const auto first = wire::IndividualAddress(static_cast<std::uint16_t>(line << 8U));
  for (auto at = last_.lower_bound(first); at != last_.end() && line_of(at->first) == line; ++at) {
    row.u8(static_cast<std::uint8_t>(number(at->first) & 0xffU));
    row.u16_be(static_cast<std::uint16_t>(at->second >> 32U));
    row.u32_be(static_cast<std::uint32_t>(at->second & 0xffffffffU));
  }
  return row.take();
}

/// What cannot be written now is written with the next number that is received.
void SenderSequences::write() {
  const auto& store = storage_.store_soon ? storage_.store_soon : storage_.store;
  if (!store) return changed_.clear();
  for (auto line = changed_.begin(); line != changed_.end();) {
    const auto written = store(senders_name(*line), row_of(*line));
    const bool keep = !written && written.error().code != ErrorCode::kUnsupported;
    if (keep) note(fmt::format("the last sequence numbers of senders cannot be stored: {}", written.error().text));
    if (written && storage_.store_soon) unsynced_ = *line;
    line = keep ? std::next(line) : changed_.erase(line);
  }
  if (unsynced_) sync_later_.request();
}

/// All lines are in one file: waiting for one of them is waiting for all.
void SenderSequences::sync() {
  if (!unsynced_ || !storage_.store) return;
  const auto line = *std::exchange(unsynced_, std::nullopt);
  if (const auto stored = storage_.store(senders_name(line), row_of(line)); !stored)
    note(fmt::format("the last sequence numbers of senders cannot be stored: {}", stored.error().text));
}

}  // namespace rubicon::networks::knx::secure
