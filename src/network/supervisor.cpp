#include "network/supervisor.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <random>
#include <utility>

#include "base/assert.h"
#include "base/log.h"

namespace rubicon::network {

namespace {

constexpr Duration kFirstPause = std::chrono::milliseconds(100);

}  // namespace

/// The host of one network. Its line is open, or a new attempt is pending, or it waits for the start.
class Supervisor::Slot final : public NetworkHost {
 public:
  Slot(Supervisor& supervisor, std::string id, Duration longest_pause)
      : supervisor_(supervisor),
        id_(std::move(id)),
        longest_pause_(longest_pause),
        log_(supervisor.log_, id_),
        rng_(static_cast<std::uint_fast32_t>(std::hash<std::string>{}(id_) + number(supervisor.island_))) {}

  /// Destroys the network first: nothing reaches it from then on.
  ~Slot() override {
    closed_ = true;
    network_.reset();
  }

  Slot(const Slot&) = delete;
  Slot& operator=(const Slot&) = delete;

  using NetworkHost::deliver;

  void deliver(Message&& message) override {
    if (closed_) return;
    message.source.island = supervisor_.island_;
    message.source.network = id_;
    if (message.destination.island == model::kNoOwner) message.destination.island = supervisor_.island_;
    if (message.kind() == MessageKind::kState) {
      auto& state = std::get<model::State>(message.body);
      complete(state);
      log_change(state);
      end_reopening(state);
    }
    supervisor_.sink_.from_network(id_, std::move(message));
  }

  void failed(Error why) override {
    if (closed_ || !opened_ || retry_.pending() || supervisor_.closing_) return;
    const Duration pause = next_pause();
    if (losses_.allow(why.text, scheduler().now())) {
      log_.warning(fmt::format("line lost: {}; next attempt in {} ms (logged at most once a minute)", why.text,
                               std::chrono::duration_cast<std::chrono::milliseconds>(pause).count()));
    }
    reported_ = why.text;
    retry_ = scheduler().after(pause, [this] { open(); });
    next_attempt_ = scheduler().wall_now() + std::chrono::ceil<std::chrono::microseconds>(pause);
    deliver({}, model::State{model::LineState::kDown, std::move(why.text), {}, {}, std::string(why.finding)});
  }

  Result<TupleWatch> watch_tuple(std::string_view tuple, std::function<void(std::string_view)> call) override {
    return supervisor_.watch_tuple_ ? supervisor_.watch_tuple_(tuple, std::move(call))
                                    : NetworkHost::watch_tuple(tuple, std::move(call));
  }

  Result<void> remember(std::string_view name, ByteView value, Keep keep) override {
    return supervisor_.memory_ ? supervisor_.memory_->remember(id_, name, value, keep)
                               : NetworkHost::remember(name, value, keep);
  }

  Result<std::optional<Bytes>> remembered(std::string_view name) override {
    return supervisor_.memory_ ? supervisor_.memory_->remembered(id_, name) : NetworkHost::remembered(name);
  }

  Scheduler& scheduler() override { return supervisor_.scheduler_; }
  transport::Transports& transports() override { return supervisor_.transports_; }
  const Log& log() const override { return log_; }

  void own(std::unique_ptr<Network> network) { network_ = std::move(network); }

  void open() {
    opened_ = true;
    next_attempt_ = {};
    ++attempts_;
    if (auto opened = network_->open(); !opened) failed(std::move(opened.error()));
  }

  Result<void> reopen(ReopenedCall ended) {
    if (!opened_ || supervisor_.closing_) return fail(ErrorCode::kRefused, "the lines of the island are closed");
    if (line_ == model::LineState::kUp) return fail(ErrorCode::kRefused, "the line is up");
    if (reopened_) return fail(ErrorCode::kRefused, "the line is being opened");
    attempts_before_ = attempts_ + own_attempts_;
    reopened_ = std::move(ended);
    if (retry_.pending()) {
      retry_.cancel();
      failures_ = 0;
      open();
      return {};
    }
    auto tried = network_->reopen();
    if (tried) return tried;
    reopened_ = nullptr;
    const bool connects = line_ == model::LineState::kConnecting;
    return fail(ErrorCode::kRefused, connects ? "the line is being opened" : std::move(tried.error().text));
  }

  Result<void> change(const NetworkConfig& config) { return network_->change(config); }
  Result<void> control(std::string_view name, std::string_view text) { return network_->control(name, text); }
  const Network* network() const { return network_.get(); }

  /// True: `said` will be called.
  bool close(std::function<void()> said) {
    retry_.cancel();
    return opened_ && network_->close(std::move(said));
  }

  Result<void> send(const Message& message) {
    if (!opened_) return fail(ErrorCode::kUnreachable, fmt::format("network {} is not open yet", id_));
    return network_->send(message);
  }

 private:
  void complete(model::State& state) {
    if (state.line == model::LineState::kUp) failures_ = 0;
    if (const auto own = state.counters.find("attempts"); own != state.counters.end()) own_attempts_ = own->second;
    state.counters["attempts"] = attempts_ + own_attempts_;
    const auto next = std::chrono::ceil<std::chrono::seconds>(next_attempt_.time_since_epoch()).count();
    auto& shown = state.counters["next-attempt"];  // a network that tries by itself says when
    shown = std::max(shown, static_cast<std::uint64_t>(std::max<std::int64_t>(next, 0)));
    line_ = state.line;
  }

  /// A report of counters may still show the line as it was before the attempt.
  void end_reopening(const model::State& state) {
    const bool tried = attempts_ + own_attempts_ > attempts_before_;
    if (!reopened_ || !tried || state.line == model::LineState::kConnecting) return;
    Result<void> outcome;
    if (state.line != model::LineState::kUp) outcome = fail(ErrorCode::kIo, state.reason);
    scheduler().post([call = std::exchange(reopened_, nullptr), outcome = std::move(outcome)] { call(outcome); });
  }

  /// Networks hold their line off by themselves where the peer refuses them: the log has each reason when it changes.
  void log_change(const model::State& state) {
    using model::LineState;
    if (state.line == LineState::kUp && state.reason.empty()) {
      if (!std::exchange(reported_, {}).empty() && losses_.allow("up", scheduler().now())) log_.info("line up");
      return;
    }
    if (state.reason.empty() || state.reason == reported_) return;
    reported_ = state.reason;
    if (!losses_.allow(state.reason, scheduler().now())) return;
    const auto text = fmt::format("line {}: {}", to_string(state.line), state.reason);
    const bool expected = state.line == LineState::kEnded || state.line == LineState::kConnecting;
    expected ? log_.info(text) : log_.warning(text);
  }

  /// 100 ms, doubled with each failure in a row, at most the type's longest, the last quarter of it by chance.
  Duration next_pause() {
    Duration pause = kFirstPause;
    for (unsigned i = 0; i < failures_ && pause < longest_pause_; ++i) pause *= 2;
    ++failures_;
    pause = std::min(pause, longest_pause_);
    return pause - pause / 4 * static_cast<Duration::rep>(rng_() % 1000) / 1000;
  }

  Supervisor& supervisor_;
  std::string id_;
  Duration longest_pause_;
  Log log_;
  std::minstd_rand rng_;
  base::RateLimit losses_;  ///< by reason
  std::string reported_;    ///< the last reason that was logged why the line is not up; empty = it is up
  std::unique_ptr<Network> network_;
  Timer retry_;
  std::uint64_t attempts_ = 0;
  WallTime next_attempt_{};         ///< zero = none is planned
  std::uint64_t own_attempts_ = 0;  ///< of the network itself, as it counts them
  unsigned failures_ = 0;
  model::LineState line_ = model::LineState::kDown;
  ReopenedCall reopened_;              ///< an attempt for a user is under way
  std::uint64_t attempts_before_ = 0;  ///< that one
  bool opened_ = false;
  bool closed_ = false;
};

Supervisor::Supervisor(IslandId island, Scheduler& scheduler, transport::Transports& transports, base::LogSink& log,
                       MessageSink& sink)
    : island_(island), scheduler_(scheduler), transports_(transports), log_(log), sink_(sink) {}

Supervisor::~Supervisor() = default;

Result<void> Supervisor::add(const NetworkType& type, const NetworkConfig& config) {
  if (has(config.id)) return fail(ErrorCode::kDuplicate, fmt::format("network {} is already there", config.id));
  auto slot = std::make_unique<Slot>(*this, config.id, type.longest_pause);
  auto network = type.make(config, *slot);
  if (!network) return fail(std::move(network.error()));
  slot->own(std::move(*network));
  Slot& added = *slots_.emplace(config.id, std::move(slot)).first->second;
  if (started_) added.open();
  return {};
}

Result<void> Supervisor::change(const NetworkConfig& config) {
  const auto found = slots_.find(config.id);
  if (found == slots_.end()) return fail(ErrorCode::kNotFound, fmt::format("there is no network {}", config.id));
  return found->second->change(config);
}

void Supervisor::start() {
  RUBICON_DEBUG_ASSERT(scheduler_.on_loop_thread());
  if (std::exchange(started_, true)) return;
  for (const auto& [id, slot] : slots_) slot->open();
}

void Supervisor::close(std::function<void()> closed) {
  if (std::exchange(closing_, true)) return;
  closed_ = std::move(closed);
  const auto in = [this](Duration span) {
    closing_timer_ = scheduler_.after(span, [this] {
      if (auto call = std::exchange(closed_, nullptr)) call();
    });
  };
  in(kClosingTime);
  for (const auto& [id, slot] : slots_) {
    const bool speaks = slot->close([this, in] {
      if (--still_closing_ == 0) in(Duration::zero());
    });
    if (speaks) ++still_closing_;
  }
  if (still_closing_ == 0) in(Duration::zero());
}

void Supervisor::remove(const std::string& id) {
  if (slots_.erase(id) == 0) return;
  Message message;
  message.source = {island_, id, {}};
  message.destination.island = island_;
  message.body = model::State{model::LineState::kDown, "the network was removed", {}};
  sink_.from_network(id, std::move(message));
}

bool Supervisor::has(const std::string& id) const {
  return slots_.contains(id);
}

const Network* Supervisor::find(const std::string& id) const {
  const auto found = slots_.find(id);
  return found == slots_.end() ? nullptr : found->second->network();
}

Result<void> Supervisor::reopen(const std::string& id, ReopenedCall ended) {
  const auto found = slots_.find(id);
  if (found == slots_.end()) return fail(ErrorCode::kNotFound, fmt::format("there is no network {}", id));
  return found->second->reopen(std::move(ended));
}

Result<void> Supervisor::control(const std::string& id, std::string_view name, std::string_view text) {
  const auto found = slots_.find(id);
  if (found == slots_.end()) return fail(ErrorCode::kNotFound, fmt::format("there is no network {}", id));
  return found->second->control(name, text);
}

std::vector<std::string> Supervisor::ids() const {
  std::vector<std::string> ids;
  for (const auto& [id, slot] : slots_) ids.push_back(id);
  return ids;
}

Result<void> Supervisor::send(const Message& message) {
  const auto found = slots_.find(message.destination.network);
  if (found == slots_.end())
    return fail(ErrorCode::kNotFound,
                fmt::format("no network {} on island {}", message.destination.network, number(island_)));
  return found->second->send(message);
}

}  // namespace rubicon::network
