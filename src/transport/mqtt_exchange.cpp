#include "transport/mqtt_exchange.h"

#include <fmt/format.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "transport/mqtt_batch.h"

namespace rubicon::transport {

namespace {

std::size_t cost(const MqttPublication& publication) {
  return publication.topic.size() + publication.payload.size() + publication.response_topic.size() +
         publication.correlation.size();
}

std::uint32_t hash_of(std::string_view topic) {
  return static_cast<std::uint32_t>(std::hash<std::string_view>()(topic));
}

}  // namespace

std::uint32_t MqttOutQueue::find(std::uint32_t hash, std::string_view topic) {
  return latest_.find(hash, [&](std::uint32_t number) { return at(number).topic == topic; });
}

Result<void> MqttOutQueue::push(MqttPublication publication, const std::string& line) {
  const bool replaces = publication.queue == MqttQueue::kLatest;
  const auto hash = hash_of(publication.topic);
  const auto known = find(hash, publication.topic);
  const bool takes_place = replaces && known != base::HashIndex::kNone;
  const auto bytes = bytes_ - (takes_place ? cost(at(known)) : 0) + cost(publication);
  if (bytes > MqttLine::kMaxQueuedBytes || (!takes_place && waiting_.size() >= MqttLine::kMaxQueued))
    return fail(ErrorCode::kBusy, fmt::format("{}: cannot publish {} bytes: {} messages with {} bytes wait already",
                                              line, cost(publication), waiting_.size(), bytes_));
  bytes_ = bytes;
  if (takes_place) {
    at(known) = std::move(publication);
    return {};
  }
  if (known != base::HashIndex::kNone) latest_.remove(hash, known);  // a later state must not overtake this one
  if (replaces) latest_.add(hash, (first_ + static_cast<std::uint32_t>(waiting_.size())) & kNumbers);
  waiting_.push_back(std::move(publication));
  return {};
}

std::optional<MqttPublication> MqttOutQueue::pop() {
  if (waiting_.empty()) return std::nullopt;
  if (const auto& front = waiting_.front(); front.queue == MqttQueue::kLatest) {
    const auto hash = hash_of(front.topic);
    const auto known = latest_.find(hash, [this](std::uint32_t number) { return number == first_; });
    if (known == first_) latest_.remove(hash, first_);
  }
  auto publication = std::move(waiting_.front());
  waiting_.pop_front();
  first_ = (first_ + 1) & kNumbers;
  bytes_ -= cost(publication);
  return publication;
}

void MqttOutQueue::take(std::size_t most_of_qos_1, std::vector<MqttPublication>& taken) {
  std::uint8_t qos = 0;
  for (std::size_t bytes = 0; !waiting_.empty() && bytes < MqttBatch::kEnough;) {
    const auto& next = waiting_.front();
    if (next.qos < qos || (next.qos > 0 && most_of_qos_1 == 0)) return;
    qos = next.qos;
    if (qos > 0) --most_of_qos_1;
    bytes += cost(next);
    taken.push_back(*pop());
  }
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
  const auto before = out_.bytes();
  if (auto queued = out_.push(std::move(publication), line_); !queued) return queued;
  if (before < MqttBatch::kEnough && out_.bytes() >= MqttBatch::kEnough) wake();
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

void MqttExchange::take_work(std::optional<std::size_t> most_of_qos_1, MqttWork& work) {
  work.asks.clear();
  work.publications.clear();
  const std::scoped_lock lock(mutex_);
  work.asks.swap(asks_);
  if (work.asks.empty() && most_of_qos_1) out_.take(*most_of_qos_1, work.publications);
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
