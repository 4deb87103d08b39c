#include "transport/mqtt_exchange.h"

#include <fmt/format.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <iterator>
#include <utility>

namespace rubicon::transport {

namespace {

std::size_t cost(const MqttPublication& publication) {
  return publication.topic.size() + publication.payload.size() + publication.response_topic.size() +
         publication.correlation.size();
}

}  // namespace

Result<void> MqttOutQueue::push(MqttPublication publication, const std::string& line) {
  const bool replaces = publication.queue == MqttQueue::kLatest;
  const auto known = replaces ? latest_.find(publication.topic) : latest_.end();
  const auto old = known == latest_.end() ? 0 : cost(waiting_[known->second - first_]);
  const auto bytes = bytes_ - old + cost(publication);
  if (bytes > MqttLine::kMaxQueuedBytes || (known == latest_.end() && waiting_.size() >= MqttLine::kMaxQueued))
    return fail(ErrorCode::kBusy, fmt::format("{}: cannot publish {} bytes: {} messages with {} bytes wait already",
                                              line, cost(publication), waiting_.size(), bytes_));
  bytes_ = bytes;
  if (known != latest_.end()) {
    waiting_[known->second - first_] = std::move(publication);
    return {};
  }
  if (!replaces) latest_.erase(publication.topic);  // a later state must not overtake it
  if (replaces) latest_[publication.topic] = first_ + waiting_.size();
  waiting_.push_back(std::move(publication));
  return {};
}

std::optional<MqttPublication> MqttOutQueue::pop() {
  if (waiting_.empty()) return std::nullopt;
  auto publication = std::move(waiting_.front());
  waiting_.pop_front();
  const auto known = latest_.find(publication.topic);
  if (known != latest_.end() && known->second == first_) latest_.erase(known);
  ++first_;
  bytes_ -= cost(publication);
  return publication;
}

void MqttHome::post(std::function<void()> call) {
  const std::scoped_lock lock(mutex_);
  if (scheduler_ != nullptr) scheduler_->post(std::move(call));
}

Result<void> MqttHome::enter(const MqttExchange& exchange) {
  const std::scoped_lock lock(mutex_);
  const auto stuck = std::count_if(served_.begin(), served_.end(), [&](const MqttExchange* one) {
    return one->dismissed() && !one->answered && one->line() == exchange.line();
  });
  if (static_cast<std::size_t>(stuck) >= kMaxStuck)
    return fail(
        ErrorCode::kBusy,
        fmt::format("{}: {} earlier attempts still wait for the host, or for the name server that should find it",
                    exchange.line(), stuck));
  if (served_.size() >= kMaxThreads)
    return fail(
        ErrorCode::kBusy,
        fmt::format("{}: {} connections to MQTT brokers are open or being opened, as many as a process may have",
                    exchange.line(), kMaxThreads));
  served_.push_back(&exchange);
  return {};
}

void MqttHome::leave(const MqttExchange& exchange) {
  const std::scoped_lock lock(mutex_);
  std::erase(served_, &exchange);
}

void MqttHome::connected(bool now) {
  const std::scoped_lock lock(mutex_);
  connections_ += now ? 1 : -1;
  changed_.notify_all();
}

void MqttHome::close(Duration patience) {
  std::unique_lock lock(mutex_);
  scheduler_ = nullptr;
  changed_.wait_for(lock, patience, [this] { return connections_ == 0; });
}

std::shared_ptr<MqttExchange> MqttExchange::make(std::shared_ptr<MqttHome> home, std::string line,
                                                 std::function<void()> on_events) {
  auto exchange = std::make_shared<MqttExchange>(std::move(home), std::move(line));
  exchange->on_events_ = std::move(on_events);
  exchange->wake_ = ::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
  return exchange->wake_ < 0 ? nullptr : exchange;
}

MqttExchange::~MqttExchange() {
  if (wake_ >= 0) ::close(wake_);
}

void MqttExchange::wake() const {
  ::eventfd_write(wake_, 1);
}

void MqttExchange::clear_wake() const {
  eventfd_t count = 0;
  ::eventfd_read(wake_, &count);
}

Result<void> MqttExchange::publish(MqttPublication publication) {
  const std::scoped_lock lock(mutex_);
  const bool first = out_.empty();
  if (auto queued = out_.push(std::move(publication), line_); !queued) return queued;
  if (first) wake();
  return {};
}

Result<void> MqttExchange::ask(MqttAsk ask) {
  const std::scoped_lock lock(mutex_);
  if (asked_bytes_ + cost(ask) > MqttLine::kMaxAskedBytes)
    return fail(ErrorCode::kBusy,
                fmt::format("{}: cannot subscribe: filters with {} bytes wait for the broker", line_, +asked_bytes_));
  asked_bytes_ += cost(ask);
  asks_.push_back(std::move(ask));
  wake();
  return {};
}

void MqttExchange::dismiss() {
  dismissed_ = true;
  wake();
}

std::vector<MqttEvent> MqttExchange::take() {
  const std::scoped_lock lock(mutex_);
  return std::exchange(events_, {});
}

void MqttExchange::delivered(std::size_t bytes) {
  const auto before = in_flight_.fetch_sub(bytes);
  if (before >= MqttLine::kMaxUndelivered && before - bytes < MqttLine::kMaxUndelivered) wake();
}

MqttWork MqttExchange::take_work(bool publication) {
  const std::scoped_lock lock(mutex_);
  MqttWork work{std::exchange(asks_, {})};
  if (publication) work.publication = out_.pop();
  return work;
}

void MqttExchange::tell(std::vector<MqttEvent> events) {
  if (events.empty()) return;
  std::size_t bytes = 0;
  for (const auto& event : events) bytes += cost(event);
  in_flight_ += bytes;
  {
    const std::scoped_lock lock(mutex_);
    const bool waits = !events_.empty();
    events_.insert(events_.end(), std::make_move_iterator(events.begin()), std::make_move_iterator(events.end()));
    if (waits) return;
  }
  home_->post(on_events_);
}

std::size_t MqttExchange::cost(const MqttEvent& event) {
  const auto* about = event.about.get();
  const auto more =
      about ? sizeof *about + about->response_topic.size() + about->correlation.size() + about->sender.size() : 0;
  return sizeof event + event.topic.size() + event.payload.size() + more;
}

}  // namespace rubicon::transport
