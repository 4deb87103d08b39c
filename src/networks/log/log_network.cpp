#include "networks/log/log_network.h"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <iterator>
#include <set>

#include "base/rate_limit.h"
#include "networks/log/csv_recording.h"
#include "networks/log/file_chain.h"
#include "networks/log/file_list.h"
#include "networks/log/log_options.h"
#include "networks/log/log_sample.h"
#include "networks/log/packet_recording.h"
#include "networks/log/tuple_recording.h"

namespace rubicon::networks::log {

namespace {

using namespace std::chrono_literals;
using model::LineState;

/// What one turn of the loop may deliver and read, so that the gateway's queue (10,000) never overflows and nobody
/// waits. What one message holds comes on top (a recording of ours: at most 250 readings).
constexpr std::size_t kReadingsPerTurn = 1000;
constexpr std::size_t kPiecesPerTurn = 16;
/// Text of this size counts as a reading more.
constexpr std::size_t kTextPerReading = 1024;
constexpr Duration kCountersEvery = 5s;
/// Between two rounds of a loop that is played as fast as possible, so that others get their turn.
constexpr Duration kBreath = 1ms;

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

/// In the part before the start offset only what devices are is told, not what they measured.
bool told_when_passed_over(const model::Body& body) {
  if (const auto* updates = std::get_if<model::Updates>(&body))
    return updates->readings.front().point.kind == Kind::kProperty;
  return std::holds_alternative<model::Join>(body) || std::holds_alternative<model::Leave>(body);
}

class LogNetwork final : public network::Network {
 public:
  LogNetwork(const network::NetworkConfig& config, LogOptions options, network::NetworkHost& host)
      : options_(std::move(options)),
        host_(host),
        types_(config.types),
        clock_(options_.speed, options_.longest_gap, options_.start) {}

  Result<void> open() override;
  Result<void> send(const Message& message) override;
  std::optional<std::vector<network::ListedDevice>> listed() const override;
  std::vector<network::Missing> missing() const override;

 private:
  Result<void> choose_format(const std::string& first_file);
  void leave_or_stay(const std::string& reason);
  void leave_some(const std::string& reason);
  std::unique_ptr<Recording> make_recording();
  void play();
  bool fetch();
  void tell(std::size_t& weight);
  void now_up();
  void deliver(const std::string& device, model::Body body, WallTime when);
  void play_later();
  void finish();
  void play_again();
  void fail_line(Error why);
  void end_line(const std::string& reason);
  void complain(std::uint64_t offset, std::string_view what);
  void report(LineState line, std::string reason = {});

  LogOptions options_;
  network::NetworkHost& host_;
  const TypeCatalogue& types_;
  ReplayClock clock_;
  ReplayCounters counters_;
  std::unique_ptr<Recording> recording_;  ///< from the first opening on, when the format is known
  std::unique_ptr<FileChain> chain_;
  std::optional<Step> step_;      ///< read, not yet due
  std::size_t next_message_ = 0;  ///< what was told of it already goes before
  bool up_ = false;
  std::deque<std::string> leaving_;  ///< at the end, still to be told
  RecordTime position_{};
  std::uint64_t told_ = 0;  ///< in this round
  std::uint64_t rounds_ = 0;
  bool told_of_step_back_ = false;
  SteadyTime next_report_{};
  base::RateLimit complaints_;
  Timer timer_;
  std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);  ///< posted calls look whether we still are
};

std::unique_ptr<Recording> LogNetwork::make_recording() {
  Complaint complain = [this](std::uint64_t offset, std::string_view what) { this->complain(offset, what); };
  if (options_.csv) return std::make_unique<CsvRecording>(*options_.csv, counters_, std::move(complain));
  if (options_.format == LogOptions::Format::kTuples)
    return std::make_unique<TupleRecording>(types_, options_.network, counters_, std::move(complain));
  return std::make_unique<PacketRecording>(types_, options_.calibration, counters_, std::move(complain));
}

/// By the first bytes of a file, unless the configuration said it; kInvalid if they contradict.
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
  if (options_.format == Format::kFound && *count < beginning.size())
    return fail(ErrorCode::kIo,
                fmt::format("{}: has {} bytes yet, expected at least {} to tell a recording from packets "
                            "(or say format: packets, recording or csv)",
                            first_file, *count, beginning.size()));
  if (options_.format == Format::kFound) options_.format = ours ? Format::kTuples : Format::kPackets;
  if (ours && options_.format == Format::kPackets)
    return fail(ErrorCode::kInvalid, first_file + ": is a recording, expected packets (say format: recording)");
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
  }
  if (auto opened = chain_->open(std::move(*files)); !opened) return opened;
  step_.reset();
  up_ = false;
  clock_.restart(host_.scheduler().now());
  recording_->ready() ? now_up() : report(LineState::kConnecting, "the recording is being read");
  play_later();
  return {};
}

Result<void> LogNetwork::send(const Message& message) {
  if (const auto* sample = std::get_if<model::Sample>(&message.body)) {
    host_.deliver(message.destination.device,
                  model::Acknowledge{sample->request, model::Outcome::kSent, "a recording plays whatever is asked"});
    return {};
  }
  const auto kind = message.kind();
  if (kind == MessageKind::kActuate || kind == MessageKind::kSetProperty)
    return fail(ErrorCode::kRefused, "recorded devices cannot be actuated");
  return fail(ErrorCode::kUnsupported, fmt::format("a recording takes no {}", to_string(kind)));
}

/// A table's columns are in the options; what other recordings hold, they say themselves.
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

void LogNetwork::play_later() {
  host_.scheduler().post([this, alive = std::weak_ptr<bool>(alive_)] {
    if (alive.lock()) play();
  });
}

/// One turn: tells what is due, then waits for the next step, or goes on in the next turn.
void LogNetwork::play() {
  timer_.cancel();
  std::size_t weight = 0;
  for (std::size_t pieces = 0; weight < kReadingsPerTurn && pieces < kPiecesPerTurn;) {
    if (!step_) {
      if (!fetch()) return;
      if (!step_) ++pieces;
      if (!step_) continue;
    }
    const SteadyTime due = clock_.due(position_);
    if (due > host_.scheduler().now()) {
      timer_ = host_.scheduler().at(due, [this] { play(); });
      return;
    }
    tell(weight);
  }
  play_later();
}

/// Fills step_ if the files give one without reading on; false when there is nothing to go on with.
bool LogNetwork::fetch() {
  Step step;
  const auto got = chain_->next(step);
  if (!got) {
    recording_->failure() ? end_line(got.error().text) : fail_line(got.error());
    return false;
  }
  if (!up_ && recording_->ready()) now_up();
  switch (*got) {
    case FileChain::Got::kStep: break;
    case FileChain::Got::kNothingYet: return true;
    case FileChain::Got::kNextFile:
      if (options_.between_files || !recording_->absolute_times())
        clock_.break_off(std::chrono::floor<RecordTime>(options_.between_files.value_or(recording_->period())));
      return true;
    case FileChain::Got::kEnd: finish(); return false;
  }
  position_ = clock_.advance(step.time);
  if (clock_.went_back() && !std::exchange(told_of_step_back_, true))
    host_.log().warning(fmt::format("{}: time steps back, taken as no pause", chain_->path()));
  step_ = std::move(step);
  next_message_ = 0;
  return true;
}

void LogNetwork::now_up() {
  up_ = true;
  report(LineState::kUp);
}

/// Goes on with it in the next turn when this one has told enough.
void LogNetwork::tell(std::size_t& weight) {
  const bool passed_over = clock_.passed_over(position_);
  const WallTime now = host_.scheduler().wall_now();
  const WallTime when = options_.recorded_times ? step_->wall.value_or(now) : now;
  auto& messages = step_->messages;
  while (next_message_ < messages.size() && weight < kReadingsPerTurn) {
    auto& [device, body] = messages[next_message_++];
    weight += weight_of(body);
    if (passed_over && !told_when_passed_over(body)) continue;
    ++told_;
    deliver(device, std::move(body), when);
  }
  if (next_message_ == messages.size()) step_.reset();
  if (host_.scheduler().now() >= next_report_) report(LineState::kUp);
}

void LogNetwork::deliver(const std::string& device, model::Body body, WallTime when) {
  if (auto* updates = std::get_if<model::Updates>(&body)) {
    const bool as_recorded = options_.recorded_times && recording_->has_user_times();
    if (!as_recorded) {
      for (model::Reading& reading : updates->readings) reading.user_time = when;
    }
    counters_.readings += updates->readings.size();
  }
  if (auto* join = std::get_if<model::Join>(&body)) {
    for (auto& capability : join->capabilities) capability.deadline = capability.deadline.value_or(options_.deadline);
  }
  host_.deliver(device, std::move(body));
}

void LogNetwork::finish() {
  if (options_.loop && told_ > 0) {
    ++rounds_;
    host_.log().info(fmt::format("{}: end reached, playing again", chain_->path()));
    report(LineState::kUp);
    timer_ = host_.scheduler().after(kBreath, [this] { play_again(); });
    return;
  }
  if (told_ == 0) host_.log().warning(fmt::format("{}: nothing in it to play", chain_->path()));
  leave_or_stay("the recording ended");
}

void LogNetwork::play_again() {
  told_ = 0;
  told_of_step_back_ = false;
  if (auto opened = chain_->rewind(); !opened) return fail_line(std::move(opened.error()));
  clock_.restart(host_.scheduler().now());
  play();
}

void LogNetwork::fail_line(Error why) {
  if (complaints_.allow(why.text, host_.scheduler().now())) host_.log().warning(why.text);
  host_.failed(std::move(why));
}

/// What reading again cannot cure is told once, and the line does not come back.
void LogNetwork::end_line(const std::string& reason) {
  host_.log().error(reason);
  leave_or_stay(reason);
}

/// As many at once as a turn may tell.
void LogNetwork::leave_or_stay(const std::string& reason) {
  if (recording_ && options_.end == LogOptions::End::kLeave) {
    auto devices = recording_->devices();
    leaving_.assign(std::make_move_iterator(devices.begin()), std::make_move_iterator(devices.end()));
  }
  leave_some(reason);
}

void LogNetwork::leave_some(const std::string& reason) {
  for (std::size_t i = 0; i < kReadingsPerTurn && !leaving_.empty(); ++i) {
    host_.deliver(std::move(leaving_.front()), model::Leave{reason});
    leaving_.pop_front();
  }
  if (!leaving_.empty()) {
    timer_ = host_.scheduler().after(kBreath, [this, reason] { leave_some(reason); });
    return;
  }
  report(LineState::kEnded, reason);
  if (options_.end == LogOptions::End::kStop) report(LineState::kDown, reason);
}

void LogNetwork::complain(std::uint64_t offset, std::string_view what) {
  if (!complaints_.allow("damage", host_.scheduler().now())) return;
  host_.log().warning(fmt::format("{}: byte {}: {} ({} damaged places so far, next report in a minute)", chain_->path(),
                                  offset, what, counters_.damaged));
}

void LogNetwork::report(LineState line, std::string reason) {
  next_report_ = host_.scheduler().now() + kCountersEvery;
  model::State state{line, std::move(reason), {}};
  state.counters = {{"records", counters_.records}, {"readings", counters_.readings},
                    {"damaged", counters_.damaged}, {"skipped-bytes", counters_.skipped_bytes},
                    {"lines", counters_.lines},     {"rounds", rounds_}};
  host_.deliver("", std::move(state));
}

}  // namespace

const network::NetworkType kType{
    .name = "log",
    .summary = "replays recordings: our own, the original's packet logs, CSV tables",
    .sample_config = kSample,
    .make = network::make_network<LogNetwork, read_log_options>,
};

}  // namespace rubicon::networks::log
