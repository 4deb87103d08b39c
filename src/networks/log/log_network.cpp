#include "networks/log/log_network.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <set>

#include "networks/log/file_chain.h"
#include "networks/log/foreign_recordings.h"
#include "networks/log/log_network_impl.h"
#include "networks/log/log_sample.h"
#include "networks/log/tuple_recording.h"

namespace rubicon::networks::log {

namespace {

using namespace std::chrono_literals;
using model::LineState;

/// What one turn of the loop delivers and reads at most, so that the gateway's queue (10,000) does not overflow and
/// other networks need not wait. The last message may exceed it (by 250 readings in a recording of our own).
constexpr std::size_t kReadingsPerTurn = 1000;
constexpr std::size_t kPiecesPerTurn = 16;
/// As many skipped readings cost as much as one delivered reading.
constexpr std::size_t kSkippedPerReading = 10;
/// As many bytes of text count as one more reading.
constexpr std::size_t kTextPerReading = 1024;
constexpr Duration kCountersEvery = 5s;
/// Between two rounds of a loop, which may be played as fast as possible.
constexpr Duration kLoopPause = 1ms;

std::size_t text_in(const Value& value) {
  if (const auto* text = std::get_if<std::string>(&value)) return text->size();
  const auto* json = std::get_if<Json>(&value);
  return json == nullptr ? 0 : json->text.size();
}

/// In readings.
std::size_t weight_of(const model::Body& body) {
  const auto* updates = std::get_if<model::Updates>(&body);
  if (updates == nullptr) return 1;
  std::size_t text = 0;
  for (const auto& reading : updates->readings) text += text_in(reading.value);
  return updates->readings.size() + text / kTextPerReading;
}

/// Before the option `start` joins, leaves and properties are played, readings are not.
bool is_played_when_skipped(const model::Body& body) {
  if (const auto* updates = std::get_if<model::Updates>(&body))
    return updates->readings.front().point.kind == Kind::kProperty;
  return std::holds_alternative<model::Join>(body) || std::holds_alternative<model::Leave>(body);
}

}  // namespace

LogNetwork::LogNetwork(const network::NetworkConfig& config, LogOptions options, network::NetworkHost& host)
    : options_(std::move(options)),
      host_(host),
      types_(config.types),
      clock_(options_.speed, options_.longest_gap, options_.start),
      last_readings_(config.types),
      log_(host.limited_log()),
      reporter_(
          host, [this] { return state(); }, kCountersEvery),
      next_turn_(host.scheduler(), [this] { play(); }) {}

std::unique_ptr<Recording> LogNetwork::make_recording() {
  Complaint complain = [this](std::uint64_t offset, std::string_view what) { this->complain(offset, what); };
  if (options_.csv) return std::make_unique<CsvRecording>(*options_.csv, counters_, std::move(complain));
  if (options_.format == LogOptions::Format::kTuples)
    return std::make_unique<TupleRecording>(types_, options_.network, counters_, std::move(complain));
  return std::make_unique<PacketRecording>(types_, options_.calibration, counters_, std::move(complain));
}

/// By the first bytes of the file, unless the configuration names the format; kInvalid if they contradict it.
Result<void> LogNetwork::choose_format(const std::string& first_file) {
  using Format = LogOptions::Format;
  if (options_.format == Format::kCsv) return {};
  auto file = host_.transports().open_file(first_file);
  if (!file) return fail(file.error());
  Bytes beginning(recording::kMagic.size());
  const auto count = (*file)->read(beginning);
  if (!count) return fail(count.error());
  const bool ours =
      *count == beginning.size() && std::equal(beginning.begin(), beginning.end(), recording::kMagic.begin());
  if (options_.format == Format::kDetect && *count < beginning.size())
    return fail(ErrorCode::kIo,
                fmt::format("{}: has {} bytes, expected at least {}, which show whether it is a recording or packets "
                            "(the option `format` names it: packets, recording or csv)",
                            first_file, *count, beginning.size()));
  if (options_.format == Format::kDetect) options_.format = ours ? Format::kTuples : Format::kPackets;
  if (ours && options_.format == Format::kPackets)
    return fail(ErrorCode::kInvalid, first_file + ": is a recording, expected packets (use `format: recording`)");
  return {};
}

Result<void> LogNetwork::open() {
  timer_.cancel();
  auto files = list_files(options_.files, options_.directory);
  if (!files) return fail(files.error());
  if (recording_ && recording_->failure()) {
    chain_.reset();
    recording_.reset();
  }
  if (!recording_) {
    if (auto chosen = choose_format(files->front()); !chosen) {
      if (chosen.error().code != ErrorCode::kInvalid) return chosen;
      end_line(chosen.error().text);
      return {};
    }
    recording_ = make_recording();
    chain_ = std::make_unique<FileChain>(host_.transports(), *recording_);
    if (options_.format == LogOptions::Format::kTuples) end_ = end_of_recording(host_.transports(), files->back());
  }
  if (auto opened = chain_->open(std::move(*files)); !opened) return opened;
  step_.reset();
  behind_kept_.reset();
  kept_ = up_ = ended_ = false;
  clock_.restart(host_.scheduler().now());
  if (recording_->ready()) {
    line_up();
  } else {
    report(LineState::kConnecting, "the recording is being read");
  }
  next_turn_.request();
  return {};
}

Result<void> LogNetwork::send(const Message& message) {
  if (const auto* sample = std::get_if<model::Sample>(&message.body)) {
    host_.deliver(message.destination.device,
                  model::Acknowledge{sample->request, model::Outcome::kSent, "a recording plays at its own pace"});
    return {};
  }
  const auto kind = message.kind();
  if (kind == MessageKind::kActuate || kind == MessageKind::kSetProperty)
    return fail(ErrorCode::kRefused, "recorded devices take no commands");
  return fail(ErrorCode::kUnsupported, fmt::format("a recording takes no {}", to_string(kind)));
}

/// The options list the devices of a table; those of other recordings are in the files.
std::optional<std::vector<network::ListedDevice>> LogNetwork::listed() const {
  if (!options_.csv) return std::nullopt;
  std::vector<network::ListedDevice> all;
  for (const auto& device : options_.csv->devices) {
    auto& listed = all.emplace_back(network::ListedDevice{device.device, {}});
    for (const auto& column : device.columns) listed.capabilities.push_back(column.capability);
    for (const auto& property : device.properties) listed.capabilities.push_back(property.capability);
  }
  return all;
}

std::vector<network::Missing> LogNetwork::missing() const {
  std::vector<network::Missing> all;
  const auto* option = options_.one_file ? "file" : "files";
  for (const auto& configured : options_.files) {
    const auto files = list_files({configured}, options_.directory);
    if (!files) all.push_back({option, files.error().text});
    for (const auto& file : files.value_or(std::vector<std::string>())) {
      if (const auto there = host_.transports().open_file(file); !there) all.push_back({option, there.error().text});
    }
  }
  if (!options_.csv) return all;
  std::set<std::string> tables;
  for (const auto& device : options_.csv->devices) {
    for (const auto& property : device.properties) {
      if (property.source != PropertyMapping::Source::kTable || !tables.insert(property.text).second) continue;
      if (const auto there = host_.transports().open_file(property.text); !there)
        all.push_back({"map", there.error().text});
    }
  }
  return all;
}

/// One turn: delivers what is due, then waits for the next step, or continues in the next turn.
void LogNetwork::play() {
  timer_.cancel();
  std::size_t weight = 0;
  for (std::size_t pieces = 0; weight < kReadingsPerTurn * kSkippedPerReading && pieces < kPiecesPerTurn;) {
    if (clock_.paused() && up_ && !target_ && !kept_) return;
    if (!step_) {
      if (!fetch()) return;
      if (!step_) ++pieces;
      if (!step_) continue;
    }
    if (plays_later()) return;
    deliver_step(weight);
  }
  next_turn_.request();
}

/// True: step_ is not due; play() is called when it is, or when a pause ends.
bool LogNetwork::plays_later() {
  if (target_ || kept_) return false;
  const SteadyTime due = clock_.due(position_);
  if (due <= host_.scheduler().now()) return false;
  if (!clock_.paused()) timer_ = host_.scheduler().at(due, [this] { play(); });
  return true;
}

/// Reads one piece; fills step_ if that completes one. False: nothing to play.
bool LogNetwork::fetch() {
  Step step;
  const auto found = chain_->next(step);
  if (!found) {
    if (recording_->failure()) {
      end_line(found.error().text);
    } else {
      fail_line(found.error());
    }
    return false;
  }
  if (!up_ && recording_->ready()) line_up();
  switch (*found) {
    case FileChain::Found::kStep: break;
    case FileChain::Found::kNothingYet: return true;
    case FileChain::Found::kNextFile:
      if (options_.between_files || !recording_->absolute_times())
        clock_.break_off(std::chrono::floor<RecordTime>(options_.between_files.value_or(recording_->period())));
      return true;
    case FileChain::Found::kEnd: finish(); return false;
  }
  position_ = clock_.advance(step.time);
  if (clock_.went_back() && !std::exchange(step_back_logged_, true))
    host_.log().warning(fmt::format("{}: time steps back; played without a pause", chain_->path()));
  time_ = recording_->absolute_times() ? step.time : position_;
  if (!begin_) {
    begin_ = time_;
    reporter_.line_changed();
  }
  step_ = std::move(step);
  next_message_ = 0;
  end_search();
  return true;
}

void LogNetwork::line_up() {
  up_ = true;
  report(LineState::kUp);
  tick();
}

/// Delivers messages of step_ until the turn is full.
void LogNetwork::deliver_step(std::size_t& weight) {
  const bool skipped = !kept_ && (target_ || clock_.is_skipped(position_));
  const WallTime now = host_.scheduler().wall_now();
  const WallTime when = options_.recorded_times ? step_->wall.value_or(now) : now;
  auto& messages = step_->messages;
  while (next_message_ < messages.size() && weight < kReadingsPerTurn * kSkippedPerReading) {
    auto& [device, body] = messages[next_message_++];
    const auto cost = weight_of(body);
    if (skipped && !is_played_when_skipped(body)) {
      weight += cost;
      if (const auto* updates = std::get_if<model::Updates>(&body); updates && target_)
        last_readings_.keep(device, *updates, has_user_times() ? WallTime{} : when);
      continue;
    }
    weight += cost * kSkippedPerReading;
    ++delivered_;
    deliver(device, std::move(body), when);
  }
  if (next_message_ == messages.size()) {
    step_ = std::exchange(behind_kept_, std::nullopt);
    next_message_ = 0;
    kept_ = false;
  }
  reporter_.counters_changed();
}

void LogNetwork::deliver(const std::string& device, model::Body body, WallTime when) {
  if (auto* updates = std::get_if<model::Updates>(&body)) {
    if (!kept_ && !has_user_times()) {
      for (model::Reading& reading : updates->readings) reading.user_time = when;
    }
    counters_.readings += updates->readings.size();
  }
  if (auto* join = std::get_if<model::Join>(&body)) {
    for (auto& capability : join->capabilities) capability.deadline = capability.deadline.value_or(options_.deadline);
    last_readings_.joined(device, *join);
  }
  if (std::holds_alternative<model::Leave>(body)) last_readings_.left(device);
  host_.deliver(device, std::move(body));
}

void LogNetwork::finish() {
  end_ = std::max(end_.value_or(time_), time_);
  if (std::exchange(target_, std::nullopt) && deliver_kept()) return next_turn_.request();
  if (options_.loop && delivered_ > 0) {
    ++rounds_;
    host_.log().info(fmt::format("{}: end reached, playing again", chain_->path()));
    report(LineState::kUp);
    timer_ = host_.scheduler().after(kLoopPause, [this] { play_again(); });
    return;
  }
  if (delivered_ == 0) host_.log().warning(fmt::format("{}: no messages to play", chain_->path()));
  leave_or_stay("the recording ended");
}

void LogNetwork::play_again() {
  if (rewind()) play();
}

/// Plays from the first file on. An error has failed the line already.
Result<void> LogNetwork::rewind() {
  timer_.cancel();
  step_.reset();
  behind_kept_.reset();
  last_readings_.clear();
  delivered_ = 0;
  kept_ = step_back_logged_ = false;
  leaving_.clear();
  const bool left = ended_ && options_.end == LogOptions::End::kLeave;
  if (left) recording_.reset();  // a new one lets its devices join again
  auto opened = left ? open() : chain_->rewind();
  if (!opened) {
    auto why = opened.error();
    fail_line(std::move(opened.error()));
    return fail(std::move(why));
  }
  if (left) return {};
  clock_.restart(host_.scheduler().now());
  if (std::exchange(ended_, false)) line_up();
  return {};
}

void LogNetwork::fail_line(Error why) {
  log_.warning(why.text, why.text);
  line_.reset();
  host_.failed(std::move(why));
}

/// For errors that reading again does not cure: logs once; the line stays down.
void LogNetwork::end_line(const std::string& reason) {
  host_.log().error(reason);
  leave_or_stay(reason);
}

void LogNetwork::leave_or_stay(const std::string& reason) {
  ended_ = true;
  if (recording_ && options_.end == LogOptions::End::kLeave) {
    auto devices = recording_->devices();
    leaving_.assign(std::make_move_iterator(devices.begin()), std::make_move_iterator(devices.end()));
  }
  leave_some(reason);
}

/// Some in each turn.
void LogNetwork::leave_some(const std::string& reason) {
  for (std::size_t i = 0; i < kReadingsPerTurn && !leaving_.empty(); ++i) {
    host_.deliver(std::move(leaving_.front()), model::Leave{reason});
    leaving_.pop_front();
  }
  if (!leaving_.empty()) {
    timer_ = host_.scheduler().after(kLoopPause, [this, reason] { leave_some(reason); });
    return;
  }
  report(LineState::kEnded, reason);
  if (options_.end == LogOptions::End::kStop) report(LineState::kDown, reason);
}

void LogNetwork::complain(std::uint64_t offset, std::string_view what) {
  log_.warning("damage", fmt::format("{}: byte {}: {} ({} damaged places so far, next report in a minute)",
                                     chain_->path(), offset, what, counters_.damaged));
}

void LogNetwork::report(LineState line, std::string reason) {
  line_ = line;
  reason_ = std::move(reason);
  reporter_.line_changed();
}

std::optional<model::State> LogNetwork::state() const {
  if (!line_) return std::nullopt;
  model::State state{*line_,
                     reason_,
                     {{"records", counters_.records},
                      {"readings", counters_.readings},
                      {"damaged", counters_.damaged},
                      {"skipped-bytes", counters_.skipped_bytes},
                      {"lines", counters_.lines},
                      {"rounds", rounds_}}};
  add_replay_texts(state.texts);
  return state;
}

const network::NetworkType kType{
    .name = "log",
    .summary = "replays recordings: our own, the original's packet logs, CSV tables",
    .sample_config = kSample,
    .make = network::make_network<LogNetwork, read_log_options>,
};

}  // namespace rubicon::networks::log
