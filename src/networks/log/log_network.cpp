#include "networks/log/log_network.h"

#include <fmt/format.h>

#include <algorithm>

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
/// waits.
constexpr std::size_t kReadingsPerTurn = 2000;
constexpr std::size_t kPiecesPerTurn = 16;
constexpr Duration kCountersEvery = 5s;
/// Between two rounds of a loop that is played as fast as possible, so that others get their turn.
constexpr Duration kBreath = 1ms;

std::size_t readings_in(const model::Body& body) {
  const auto* updates = std::get_if<model::Updates>(&body);
  return updates == nullptr ? 1 : updates->readings.size();
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

 private:
  Result<void> choose_format(const std::string& first_file);
  std::unique_ptr<Recording> make_recording();
  void play();
  bool fetch();
  void tell(std::size_t& readings);
  void deliver(const std::string& device, model::Body body, WallTime when);
  void play_later();
  void finish();
  void play_again();
  void fail_line(Error why);
  void complain(std::uint64_t offset, std::string_view what);
  void report(LineState line, std::string reason = {});

  LogOptions options_;
  network::NetworkHost& host_;
  const TypeCatalogue& types_;
  ReplayClock clock_;
  ReplayCounters counters_;
  std::unique_ptr<Recording> recording_;  ///< from the first opening on, when the format is known
  std::unique_ptr<FileChain> chain_;
  std::optional<Step> step_;  ///< read, not yet due
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

/// By the first bytes of a file, unless the configuration said it; then they must not contradict.
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
  if (options_.format == Format::kFound) options_.format = ours ? Format::kTuples : Format::kPackets;
  if (ours && options_.format == Format::kPackets)
    return fail(ErrorCode::kInvalid, first_file + ": is a recording, expected packets (say format: recording)");
  return {};
}

Result<void> LogNetwork::open() {
  auto files = list_files(options_.files, options_.directory);
  if (!files) return fail(files.error());
  if (!recording_) {
    if (auto chosen = choose_format(files->front()); !chosen) return chosen;
    recording_ = make_recording();
    chain_ = std::make_unique<FileChain>(host_.transports(), *recording_);
  }
  if (auto opened = chain_->open(std::move(*files)); !opened) return opened;
  step_.reset();
  clock_.restart(host_.scheduler().now());
  report(LineState::kUp);
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

void LogNetwork::play_later() {
  host_.scheduler().post([this, alive = std::weak_ptr<bool>(alive_)] {
    if (alive.lock()) play();
  });
}

/// One turn: tells what is due, then waits for the next step, or goes on in the next turn.
void LogNetwork::play() {
  timer_.cancel();
  std::size_t readings = 0;
  for (std::size_t pieces = 0; readings < kReadingsPerTurn && pieces < kPiecesPerTurn;) {
    if (!step_) {
      ++pieces;
      if (!fetch()) return;
      if (!step_) continue;
      pieces = 0;
    }
    const SteadyTime due = clock_.due(position_);
    if (due > host_.scheduler().now()) {
      timer_ = host_.scheduler().at(due, [this] { play(); });
      return;
    }
    tell(readings);
  }
  play_later();
}

/// Fills step_ if the files give one without reading on; false when there is nothing to go on with.
bool LogNetwork::fetch() {
  Step step;
  const auto got = chain_->next(step);
  if (!got) {
    fail_line(got.error());
    return false;
  }
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
  return true;
}

void LogNetwork::tell(std::size_t& readings) {
  const bool passed_over = clock_.passed_over(position_);
  const WallTime now = host_.scheduler().wall_now();
  const WallTime when = options_.recorded_times ? step_->wall.value_or(now) : now;
  for (auto& [device, body] : step_->said) {
    if (passed_over && !told_when_passed_over(body)) continue;
    readings += readings_in(body);
    ++told_;
    deliver(device, std::move(body), when);
  }
  step_.reset();
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
  if (options_.end == LogOptions::End::kLeave) {
    for (const std::string& device : recording_->devices()) host_.deliver(device, model::Leave{"the recording ended"});
  }
  report(LineState::kEnded, "the recording ended");
  if (options_.end == LogOptions::End::kStop) report(LineState::kDown, "the recording ended");
}

void LogNetwork::play_again() {
  told_ = 0;
  told_of_step_back_ = false;
  if (auto opened = chain_->rewind(); !opened) return fail_line(opened.error());
  clock_.restart(host_.scheduler().now());
  play();
}

void LogNetwork::fail_line(Error why) {
  if (complaints_.allow(why.text, host_.scheduler().now())) host_.log().warning(why.text);
  host_.failed(std::move(why));
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

Result<std::unique_ptr<network::Network>> make(const network::NetworkConfig& config, network::NetworkHost& host) {
  const std::size_t errors = config.options.errors().lines().size();
  LogOptions options = read_log_options(config);
  if (config.options.errors().lines().size() > errors)
    return fail(ErrorCode::kInvalid, fmt::format("network {}: wrong options", config.id));
  return std::make_unique<LogNetwork>(config, std::move(options), host);
}

}  // namespace

const network::NetworkType kType{"log", "replays recordings: our own, the original's packet logs, CSV tables", kSample,
                                 make};

}  // namespace rubicon::networks::log
