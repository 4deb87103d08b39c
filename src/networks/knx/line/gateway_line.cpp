#include "networks/knx/line/gateway_line.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/assert.h"

namespace rubicon::networks::knx::line {

namespace {

using Phase = LineState::Phase;

/// How long two tunnels are compared: servers forward a telegram of the bus within some milliseconds.
constexpr Duration kOverlap = std::chrono::seconds(1);
constexpr std::size_t kMaxReported = 1000;

bool is_gauge(std::string_view counter) {
  return counter == "telegrams-waiting" || counter == "next-attempt";
}

void add(std::map<std::string, std::uint64_t>& all, const std::map<std::string, std::uint64_t>& more) {
  for (const auto& [name, count] : more) {
    if (!is_gauge(name) || !all.contains(name)) all[name] += count;
  }
}

}  // namespace

GatewayLine::GatewayLine(GatewayOptions options, Scheduler& scheduler, transport::Transports& transports,
                         LineCallbacks callbacks)
    : options_(std::move(options)),
      scheduler_(scheduler),
      transports_(transports),
      callbacks_(std::move(callbacks)),
      whys_(options_.gateways.size()) {
  RUBICON_ASSERT(options_.gateways.size() >= 2);
  line_ = make_main(0);
  state_.server = options_.gateways.front().host;
}

GatewayLine::~GatewayLine() = default;

std::unique_ptr<TunnelLine> GatewayLine::make(std::size_t gateway, unsigned id, LineCallbacks calls) {
  calls.is_known = [this, id](const wire::DataFrame& frame) { return is_known(id, frame); };
  auto options = options_.tunnel;
  const auto& chosen = options_.gateways[gateway];
  options.host = chosen.host;
  options.secure = chosen.secure;
  options.wanted = chosen.wanted;
  return std::make_unique<TunnelLine>(std::move(options), scheduler_, transports_, std::move(calls));
}

/// Of a tunnel that is, was or will be in use.
LineCallbacks GatewayLine::common_calls(unsigned id) {
  LineCallbacks calls = callbacks_;
  calls.changed = [this, id](const LineState& state) {
    if (id == line_id_) return changed(state);
    if (id == next_id_) preferred_changed(state);
  };
  calls.failed = [this, id](Error why) {
    if (id == line_id_) return failed(std::move(why));
    if (id == next_id_) give_up_preferred();
  };
  return calls;
}

std::unique_ptr<TunnelLine> GatewayLine::make_main(std::size_t gateway) {
  line_id_ = ++last_id_;
  return make(gateway, line_id_, common_calls(line_id_));
}

void GatewayLine::send(wire::Telegram telegram, SteadyTime expires, SendCallback done) {
  line_->send(std::move(telegram), expires, std::move(done));
}

std::map<std::string, std::uint64_t> GatewayLine::counters() const {
  auto all = line_->counters();
  add(all, past_);
  if (old_) add(all, old_->counters());
  all["gateway-changes"] = changes_;
  return all;
}

// Which gateway is used.

bool GatewayLine::prefers(std::size_t gateway) const {
  return options_.gateways[gateway].host == options_.gateways.front().host;
}

/// The next attempt is made with this one.
void GatewayLine::choose(std::size_t gateway) {
  current_ = gateway;
  const auto& chosen = options_.gateways[gateway];
  line_->use_gateway(chosen.host, chosen.secure, chosen.wanted);
}

/// `10.0.0.9: no answer; 10.0.0.10: all tunnels are in use`, of those that were tried in vain.
std::string GatewayLine::tried_text() const {
  std::string text;
  for (std::size_t i = 0; i < whys_.size(); ++i) {
    const auto& host = options_.gateways[i].host;
    if (whys_[i].empty()) continue;
    text += fmt::format("{}{}{}", text.empty() ? "" : "; ", whys_[i].starts_with(host) ? "" : host + ": ", whys_[i]);
  }
  return text;
}

void GatewayLine::show(LineState state) {
  state_ = std::move(state);
  state_.tunnel_in_use = state_.user_refused = false;  // the other tunnels of a keyring are gateways here
  const auto& host = options_.gateways[current_].host;
  state_.gateway = prefers(current_) ? host + " (preferred)"
                                     : fmt::format("{} (instead of {})", host, options_.gateways.front().host);
  if (callbacks_.changed) callbacks_.changed(state_);
}

void GatewayLine::changed(const LineState& state) {
  if (state.phase == Phase::kWaiting || state.phase == Phase::kRefused) return refused(state);
  auto shown = state;
  if (state.phase == Phase::kUp && !std::exchange(up_, true)) {
    is_used();
  }
  if (state.phase == Phase::kUp && state.reason.empty()) shown.reason = tried_text();
  if (state.phase == Phase::kConnecting && state.reason.empty() && tried_ > 0)
    shown.reason = fmt::format("tries {}; {}", options_.gateways[current_].host, tried_text());
  show(std::move(shown));
}

/// The line is up.
void GatewayLine::is_used() {
  up_ = true;
  tried_ = 0;
  const auto& host = options_.gateways[current_].host;
  if (!used_.empty() && used_ != host) ++changes_;
  used_ = host;
  whys_[current_].clear();
  if (prefers(current_)) std::fill(whys_.begin(), whys_.end(), std::string());
  check_later();
}

/// The next gateway is tried at once; after the last the line pauses, and the first follows.
void GatewayLine::refused(const LineState& state) {
  up_ = false;
  whys_[current_] = state.reason;
  auto shown = state;
  const bool all = ++tried_ >= options_.gateways.size();
  choose(all ? 0 : current_ + 1 < options_.gateways.size() ? current_ + 1 : 0);
  if (all) {
    tried_ = 0;
  } else {
    line_->reopen();
    shown.phase = Phase::kConnecting;
  }
  shown.reason = tried_text();
  show(std::move(shown));
}

/// After a tunnel that was up the preferred gateway comes first.
void GatewayLine::failed(Error why) {
  if (next_) give_up_preferred();  // the next attempt begins with it
  whys_[current_] = why.text;
  const bool was_up = std::exchange(up_, false);
  check_.cancel();
  question_.reset();
  tried_ = was_up ? 0 : tried_ + 1;
  if (tried_ >= options_.gateways.size()) tried_ = 0;
  choose(tried_ == 0 ? 0 : current_ + 1 < options_.gateways.size() ? current_ + 1 : 0);
  why.text = fmt::format("{}; next: {}", tried_text(), options_.gateways[current_].host);
  if (callbacks_.failed) callbacks_.failed(std::move(why));
}

// Back to the preferred one.

void GatewayLine::check_later() {
  if (prefers(current_) || !options_.check) return check_.cancel();
  check_ = scheduler_.after(*options_.check, [this] { ask_preferred(); });
}

void GatewayLine::ask_preferred() {
  if (!up_ || next_ || old_) return check_later();
  DiscoveryOptions wanted;
  wanted.hosts = {{options_.gateways.front().host, options_.tunnel.port}};
  wanted.route_back = options_.tunnel.nat == TunnelOptions::Nat::kOn;
  question_ = std::make_unique<Discovery>(scheduler_, transports_, std::move(wanted), [this](DiscoveryResult result) {
    const auto done = std::move(question_);  // destroyed at the end: this is its callback
    if (!up_ || result.servers.empty()) return check_later();
    open_preferred();
  });
}

void GatewayLine::open_preferred() {
  next_gateway_ = 0;
  next_id_ = ++last_id_;
  next_ = make(0, next_id_, common_calls(next_id_));
  if (!next_->open()) give_up_preferred();
}

void GatewayLine::preferred_changed(const LineState& state) {
  if (state.phase == Phase::kUp) return take_over();
  if (state.phase != Phase::kWaiting && state.phase != Phase::kRefused) return;
  whys_[next_gateway_] = state.reason;
  if (++next_gateway_ >= options_.gateways.size() || !prefers(next_gateway_)) return give_up_preferred();
  const auto& chosen = options_.gateways[next_gateway_];
  next_->use_gateway(chosen.host, chosen.secure, chosen.wanted);
  next_->reopen();
}

/// Called by the line that is given up: it is destroyed in a later turn.
void GatewayLine::give_up_preferred() {
  next_id_ = 0;
  drop_ = scheduler_.after(Duration::zero(), [this] { next_.reset(); });
  check_later();
}

/// Called by the new line.
void GatewayLine::take_over() {
  old_ = std::exchange(line_, std::move(next_));
  line_id_ = std::exchange(next_id_, 0U);
  current_ = next_gateway_;
  is_used();
  old_->hand_over(*line_);
  overlap_ = scheduler_.after(kOverlap, [this] { end_overlap(); });
  show(line_->state());
}

/// The outcome of a telegram is known after some seconds at most.
void GatewayLine::end_overlap() {
  if (old_->sending()) {
    overlap_ = scheduler_.after(kOverlap, [this] { end_overlap(); });
    return;
  }
  old_->hand_over(*line_);
  add(past_, old_->counters());
  old_.reset();
  reported_.clear();
}

/// While two tunnels are open: whether the other one reported this frame, or we sent it by the other one.
bool GatewayLine::is_known(unsigned id, const wire::DataFrame& frame) {
  if (!next_ && !old_) return false;
  const auto& other = id == line_id_ ? old_ : line_;
  if (other && number(other->state().own) != 0 && frame.source == other->state().own) return true;
  const auto now = scheduler_.now();
  while (!reported_.empty() && (reported_.front().when + kOverlap < now || reported_.size() >= kMaxReported))
    reported_.pop_front();
  const auto same = std::find_if(reported_.begin(), reported_.end(), [&](const Reported& one) {
    return one.id != id && one.source == frame.source && one.destination == frame.destination &&
           std::equal(one.tpdu.begin(), one.tpdu.end(), frame.tpdu.begin(), frame.tpdu.end());
  });
  if (same != reported_.end()) {
    reported_.erase(same);
    return true;
  }
  reported_.push_back({now, id, frame.source, frame.destination, Bytes(frame.tpdu.begin(), frame.tpdu.end())});
  return false;
}

}  // namespace rubicon::networks::knx::line
