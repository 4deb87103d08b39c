#include "support/memory/mqtt_broker.h"

#include <algorithm>
#include <utility>

#include "base/assert.h"
#include "support/memory/memory_mqtt.h"
#include "transport/mqtt_checks.h"
#include "transport/mqtt_topics.h"

namespace rubicon::transport {

namespace {

constexpr int kBadVersion = 0x84, kBadUser = 0x86, kTakenOver = 0x8e, kTooLarge = 0x95, kNotAuthorised = 0x87;

bool matches_any(const std::set<std::string>& filters, std::string_view topic) {
  return std::any_of(filters.begin(), filters.end(), [&](const auto& filter) { return mqtt_matches(filter, topic); });
}

Error closed(const MemorySession& session) {
  return {ErrorCode::kUnreachable, session.name + ": the broker closed the connection"};
}

}  // namespace

MqttBroker::MqttBroker(MemoryNet& net, Endpoint at) : net_(net), at_(std::move(at)) {
  start();
}

MqttBroker::~MqttBroker() {
  stop(true);
}

void MqttBroker::start() {
  if (runs()) return;
  RUBICON_ASSERT(!net_.brokers.contains(at_));
  net_.brokers.emplace(at_, this);
}

void MqttBroker::stop(bool keep_retained) {
  if (runs()) net_.brokers.erase(at_);
  break_all(false);
  flights_.clear();
  held_.clear();
  if (!keep_retained) retained_.clear();
}

void MqttBroker::restart(Retained saved) {
  stop(false);
  retained_ = std::move(saved);
  start();
}

bool MqttBroker::runs() const {
  const auto found = net_.brokers.find(at_);
  return found != net_.brokers.end() && found->second == this;
}

void MqttBroker::cut() {
  break_all(true);
}

void MqttBroker::cut(std::string_view client) {
  for (const auto& session : std::vector<SessionPtr>(sessions_))
    if (session->options.client_id == client) drop(session, closed(*session), true);
}

void MqttBroker::break_all(bool with_wills) {
  for (const auto& session : std::vector<SessionPtr>(sessions_)) drop(session, closed(*session), with_wills);
}

void MqttBroker::stall(bool stalled) {
  stalled_ = stalled;
  for (const auto& session : sessions_) watch(session);
  if (stalled) return;
  for (auto& call : std::exchange(held_, {})) transit(std::move(call));
  for (const auto& session : std::vector<SessionPtr>(sessions_)) {
    take_in(session);
    if (!session->alive) leave(session);
  }
}

/// Ends a session that hears nothing while the broker is stalled.
void MqttBroker::watch(const SessionPtr& session) {
  session->silence.cancel();
  if (!stalled_ || !session->accepted) return;
  session->silence = net_.scheduler().after(session->options.keep_alive, [this, weak = std::weak_ptr(session)] {
    if (const auto silent = weak.lock())
      drop(silent, {ErrorCode::kUnreachable, silent->name + ": the broker does not answer"}, true);
  });
}

/// In the order of the calls, also where `latency` changes. What would arrive while stalled, waits.
void MqttBroker::transit(std::function<void()> call) {
  last_arrival_ = std::max(last_arrival_, net_.scheduler().now() + latency);
  const auto flight = ++last_flight_;
  flights_[flight] = net_.scheduler().at(last_arrival_, [this, flight, call = std::move(call)]() mutable {
    const auto landed = std::move(flights_.extract(flight).mapped());
    if (stalled_) return held_.push_back(std::move(call));
    call();
  });
}

void MqttBroker::connect(const SessionPtr& session) {
  session->broker = this;
  sessions_.push_back(session);
  transit([this, session] { reach(session); });
}

void MqttBroker::reach(const SessionPtr& session) {
  if (session->lost || !session->alive || !answers) return;
  const auto reason = refusal(session->options);
  if (!reason) return accept(session);
  if (*reason == kBadVersion && session->options.version == MqttVersion::kAny) {
    session->options.version = MqttVersion::k311;
    return transit([this, session] { transit([this, session] { reach(session); }); });
  }
  transit([this, session, why = mqtt_error(*reason, session->name)] { drop(session, why, false); });
}

std::optional<int> MqttBroker::refusal(const MqttOptions& options) const {
  if (options.version != MqttVersion::k311 && !speaks_5) return kBadVersion;
  if (users.empty()) return std::nullopt;
  const auto user = users.find(options.user);
  if (user == users.end() || user->second != options.password) return kBadUser;
  return std::nullopt;
}

void MqttBroker::accept(const SessionPtr& session) {
  const auto& id = session->options.client_id;
  for (const auto& other : std::vector<SessionPtr>(sessions_))
    if (other->accepted && other->options.client_id == id) drop(other, mqtt_error(kTakenOver, other->name), true);
  session->accepted = true;
  session->version_5 = session->options.version != MqttVersion::k311;
  transit([this, session] {
    if (session->lost || !session->alive) return;
    session->deadline.cancel();
    session->connected = true;
    take_in(session);
    if (session->calls.connected) session->calls.connected({});
  });
}

/// Takes what the line has for the broker.
void MqttBroker::take_in(const SessionPtr& session) {
  if (stalled_ || session->lost || !session->accepted) return;
  for (auto& call : std::exchange(session->asked, {})) {
    transit([session, call = std::move(call)] {
      if (!session->lost) call(session);
    });
  }
  while (auto publication = session->queue.pop()) {
    ++session->counters.sent;
    transit([this, session, publication = std::move(*publication)] {
      if (!session->lost) take(session, publication, false);
    });
  }
}

void MqttBroker::subscribe(const SessionPtr& session, const std::string& filter, std::uint8_t qos) {
  if (refused_filters.contains(filter)) {
    return transit([session, filter] {
      if (session->lost || !session->alive || !session->calls.refused) return;
      session->calls.refused(filter, {ErrorCode::kRefused, session->name + ": the broker refuses to send " + filter});
    });
  }
  session->filters[filter] = qos;
  for (const auto& [topic, payload] : retained_)
    if (mqtt_matches(filter, topic)) deliver(session, {topic, payload, true, qos}, true);
}

void MqttBroker::take(const SessionPtr& from, const MqttPublication& publication, bool will) {
  const auto size = packet_size(publication.topic, publication.payload);
  if (size > largest_packet && !will) return drop(from, mqtt_error(kTooLarge, from->name), true);
  const Publication seen{from->options.client_id, publication.topic, publication.payload,
                         publication.retain,      publication.qos,   will,
                         net_.scheduler().now()};
  if (keeps_published) published_.push_back(seen);
  const bool refused = matches_any(refused_topics, publication.topic);
  if (!will && publication.qos > 0) acknowledge(from, publication, refused);
  if (!refused && !matches_any(ignored_topics, publication.topic)) spread(publication);
  if (heard) heard(seen);
}

void MqttBroker::acknowledge(const SessionPtr& session, const MqttPublication& publication, bool refused) {
  if (!acknowledges) return;
  const bool says_so = refused && session->version_5;
  if (says_so) ++session->counters.not_taken;
  transit([session, topic = publication.topic, number = publication.number, says_so] {
    const auto& calls = session->calls;
    if (session->lost || !session->alive) return;
    if (says_so && calls.not_taken)
      calls.not_taken({topic, number, MqttReason::kNotAuthorised},
                      publication_error(kNotAuthorised, session->name, topic));
    else if (!says_so && calls.taken)
      calls.taken({topic, number, MqttReason::kSuccess});
  });
}

void MqttBroker::publish(std::string_view topic, std::string_view payload, bool retain, std::uint8_t qos) {
  spread({std::string(topic), std::string(payload), retain, qos});
}

void MqttBroker::spread(const MqttPublication& publication) {
  if (publication.retain && publication.payload.empty()) retained_.erase(publication.topic);
  if (publication.retain && !publication.payload.empty()) retained_[publication.topic] = publication.payload;
  for (const auto& session : sessions_) {
    const auto asked = std::find_if(session->filters.begin(), session->filters.end(),
                                    [&](const auto& filter) { return mqtt_matches(filter.first, publication.topic); });
    if (asked == session->filters.end()) continue;
    deliver(session, publication, false);
    if (repeats && publication.qos == 1 && asked->second == 1) deliver(session, publication, false);
  }
}

void MqttBroker::deliver(const SessionPtr& to, const MqttPublication& message, bool retained) {
  const bool too_long = packet_size(message.topic, message.payload) > to->options.largest_packet;
  if (too_long && to->version_5) return;
  transit([to, topic = message.topic, payload = message.payload, retained, too_long] {
    if (to->lost || !to->alive || !to->connected) return;
    ++(too_long ? to->counters.too_long : to->counters.received);
    if (too_long && to->calls.too_long) to->calls.too_long(topic, packet_size(topic, payload));
    if (!too_long && to->calls.received) to->calls.received({topic, payload, retained});
  });
}

/// The line was destroyed.
void MqttBroker::leave(const SessionPtr& session) {
  if (stalled_ && session->accepted) return;
  take_in(session);
  session->lost = !session->accepted;
  transit([this, session] { forget(session); });
}

void MqttBroker::forget(const SessionPtr& session) {
  std::erase(sessions_, session);
  session->silence.cancel();
  session->filters.clear();
  session->accepted = false;
}

void MqttBroker::drop(const SessionPtr& session, const Error& why, bool with_will) {
  const bool accepted = session->accepted;
  forget(session);
  lose(net_, session, why);
  if (const auto& will = session->options.will; will && accepted && with_will)
    take(session, {will->topic, will->payload, will->retain, 1}, true);
}

std::vector<std::string> MqttBroker::published(std::string_view topic) const {
  std::vector<std::string> payloads;
  for (const auto& publication : published_)
    if (publication.topic == topic) payloads.push_back(publication.payload);
  return payloads;
}

std::optional<std::string> MqttBroker::retained(std::string_view topic) const {
  const auto found = retained_.find(topic);
  return found == retained_.end() ? std::nullopt : std::optional(found->second);
}

std::vector<std::string> MqttBroker::clients() const {
  std::vector<std::string> ids;
  for (const auto& session : sessions_)
    if (session->accepted) ids.push_back(session->options.client_id);
  std::sort(ids.begin(), ids.end());
  return ids;
}

std::set<std::string> MqttBroker::subscriptions() const {
  std::set<std::string> filters;
  for (const auto& session : sessions_)
    for (const auto& [filter, qos] : session->filters) filters.insert(filter);
  return filters;
}

}  // namespace rubicon::transport
