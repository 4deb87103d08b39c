#include "support/memory/mqtt_broker.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "base/assert.h"
#include "support/memory/memory_mqtt.h"
#include "transport/mqtt.h"

namespace rubicon::transport {

namespace {

constexpr int kNoSubscribers = 0x10, kRefusal = 0x80, kBadVersion = 0x84, kBadUser = 0x86, kNotAuthorised = 0x87,
              kTakenOver = 0x8e, kTooLarge = 0x95, kNotRetained = 0x9a;

bool matches_any(const std::set<std::string>& filters, std::string_view topic) {
  return std::any_of(filters.begin(), filters.end(), [&](const auto& filter) { return mqtt_matches(filter, topic); });
}

Error closed(const MemorySession& session) {
  return {ErrorCode::kUnreachable, session.name + ": the broker closed the connection"};
}

Error silent(const MemorySession& session) {
  return {ErrorCode::kUnreachable, session.name + ": the broker does not answer"};
}

/// A broker of version 5 tells the reason.
Error ended(const MemorySession& session, int reason) {
  return session.version_5 ? mqtt_error(reason, session.name) : closed(session);
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
  if (keep_retained) return;
  retained_.clear();
  expiries_.clear();
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
  if (session->stalled) return;
  session->silence.cancel();
  if (!stalled_ || !session->accepted) return;
  session->silence = net_.scheduler().after(2 * session->keep_alive, [this, weak = std::weak_ptr(session)] {
    if (const auto found = weak.lock()) drop(found, silent(*found), true);
  });
}

void MqttBroker::stall(std::string_view client, bool stalled) {
  for (const auto& session : std::vector<SessionPtr>(sessions_))
    if (session->accepted && session->options.client_id == client && session->stalled != stalled)
      stalled ? begin_stall(session) : end_stall(session);
}

void MqttBroker::begin_stall(const SessionPtr& session) {
  session->stalled = true;
  const std::weak_ptr weak(session);
  auto& scheduler = net_.scheduler();
  session->silence = scheduler.after(2 * session->keep_alive, [&net = net_, weak] {
    if (const auto found = weak.lock()) lose(net, found, silent(*found));
  });
  session->half_open = scheduler.after(session->keep_alive * 3 / 2 + looks_each, [this, weak] {
    if (const auto found = weak.lock()) end_half_open(found);
  });
}

void MqttBroker::end_stall(const SessionPtr& session) {
  session->stalled = false;
  session->silence.cancel();
  session->half_open.cancel();
  take_in(session);
  drain(session);
  if (!session->alive) leave(session);
}

/// The line does not learn it.
void MqttBroker::end_half_open(const SessionPtr& session) {
  forget(session);
  session->broker = nullptr;
  take_will(*session);
}

void MqttBroker::slow(std::string_view client, Duration each) {
  for (const auto& session : sessions_) {
    if (session->options.client_id != client) continue;
    session->reads_each = each;
    session->reading.cancel();
    drain(session);
  }
}

/// After all that the client has not read yet.
void MqttBroker::send(const SessionPtr& to, MemoryPacket packet) {
  if (packet.counts && !has_room(*to, packet.qos)) return;
  to->backlog.push_back(std::move(packet));
  drain(to);
}

bool MqttBroker::has_room(const MemorySession& to, std::uint8_t qos) const {
  const auto waiting = std::count_if(to.backlog.begin(), to.backlog.end(), [&](const MemoryPacket& packet) {
    return packet.counts && (packet.qos > 0) == (qos > 0);
  });
  const auto all = static_cast<std::size_t>(waiting) + (qos > 0 ? to.in_flight : 0);
  return all < max_queued + (qos > 0 ? max_in_flight : 0);
}

void MqttBroker::drain(const SessionPtr& to) {
  const auto may_go = [&](const MemoryPacket& packet) { return packet.qos == 0 || to->in_flight < max_in_flight; };
  while (!to->stalled && !to->reading.pending()) {
    const auto next = std::find_if(to->backlog.begin(), to->backlog.end(), may_go);
    if (next == to->backlog.end()) return;
    const auto packet = std::move(*next);
    to->backlog.erase(next);
    if (packet.qos > 0 && packet.expires && *packet.expires <= net_.scheduler().now()) continue;
    go(to, packet);
  }
}

void MqttBroker::go(const SessionPtr& to, const MemoryPacket& packet) {
  if (packet.counts && to->reads_each > Duration::zero())
    to->reading = net_.scheduler().after(to->reads_each, [this, weak = std::weak_ptr(to)] {
      if (const auto found = weak.lock()) drain(found);
    });
  if (packet.qos == 0) return transit(packet.arrive);
  ++to->in_flight;
  transit([this, to, arrive = packet.arrive] {
    arrive();
    transit([this, to] {
      --to->in_flight;
      drain(to);
    });
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
  session->version_5 = session->options.version != MqttVersion::k311;
  const auto reason = refusal(session->options);
  if (!reason) return accept(session);
  if (*reason == kBadVersion && session->options.version == MqttVersion::kAny) {
    session->options.version = MqttVersion::k311;
    return transit([this, session] { transit([this, session] { reach(session); }); });
  }
  const auto why = *reason == kNotRetained ? ended(*session, *reason) : mqtt_error(*reason, session->name);
  transit([this, session, why] { drop(session, why, false); });
}

std::optional<int> MqttBroker::refusal(const MqttOptions& options) const {
  if (options.version != MqttVersion::k311 && !speaks_5) return kBadVersion;
  if (options.will && options.will->retain && !retains) return kNotRetained;
  if (users.empty()) return std::nullopt;
  const auto user = users.find(options.user);
  if (user == users.end() || user->second != options.password) return kBadUser;
  return std::nullopt;
}

void MqttBroker::accept(const SessionPtr& session) {
  const auto& id = session->options.client_id;
  for (const auto& other : std::vector<SessionPtr>(sessions_))
    if (other->accepted && other->options.client_id == id)
      drop(other, tells_take_over ? ended(*other, kTakenOver) : closed(*other), true);
  session->accepted = true;
  session->keep_alive = session->options.keep_alive;
  MqttConnack connack;
  connack.version = MqttVersion::k311;
  if (session->version_5) {
    session->keep_alive = std::min(session->keep_alive, longest_keep_alive);
    connack = {MqttVersion::k5, largest_packet == kMaxPacketSize ? 0 : largest_packet, retains, {}, {}};
  }
  connack.keep_alive = session->keep_alive;
  transit([this, session, connack]() mutable {
    if (session->lost || !session->alive) return;
    session->deadline.cancel();
    session->connected = true;
    take_in(session);
    connack.client_id = session->options.client_id;
    if (session->calls.connected) session->calls.connected(connack);
  });
}

/// Takes what the line has for the broker.
void MqttBroker::take_in(const SessionPtr& session) {
  if (stalled_ || session->stalled || session->lost || !session->accepted) return;
  for (auto& call : std::exchange(session->asked, {})) {
    transit([session, call = std::move(call)] {
      if (!session->lost && session->broker != nullptr) call(session);
    });
  }
  while (auto publication = session->queue.pop()) {
    ++session->counters.sent;
    transit([this, session, publication = std::move(*publication)] {
      if (!session->lost) take(session, publication);
    });
  }
}

void MqttBroker::subscribe(const SessionPtr& session, const std::string& filter, std::uint8_t qos) {
  const bool refused = refused_filters.contains(filter);
  send(session, {[session, filter, refused] {
         const auto& calls = session->calls;
         if (session->lost || !session->alive) return;
         if (!refused && calls.subscribed) calls.subscribed(filter);
         if (refused && calls.refused)
           calls.refused(filter, {ErrorCode::kRefused, session->name + ": the broker refuses to send " + filter});
       }});
  if (refused) return;
  session->filters[filter] = qos;
  for (const auto& [topic, payload] : retained_)
    if (mqtt_matches(filter, topic)) deliver(session, {topic, payload, true, qos}, true);
}

/// Why this publication ends the connection.
std::optional<Error> MqttBroker::end_of(const MemorySession& from, const MqttPublication& publication) const {
  if (packet_size(publication.topic, publication.payload) > largest_packet) return ended(from, kTooLarge);
  // The library takes the mark away where the broker told that it retains nothing.
  if (publication.retain && !retains && !from.version_5) return closed(from);
  return std::nullopt;
}

/// Reason code of its PUBACK; 0 = it is sent on.
int MqttBroker::fault_of(const MemorySession& from, const MqttPublication& publication) const {
  if (publication.payload.size() > largest_payload) return kTooLarge;
  if (matches_any(refused_topics, publication.topic)) return kNotAuthorised;
  if (rights && !rights->may_write(from.options.user, publication.topic)) return kNotAuthorised;
  return 0;
}

void MqttBroker::take(const SessionPtr& from, const MqttPublication& publication) {
  if (const auto why = end_of(*from, publication)) return drop(from, *why, true);
  const Publication seen{from->options.client_id, publication.topic,       publication.payload,
                         publication.retain,      publication.qos,         false,
                         net_.scheduler().now(),  publication.correlation, publication.expiry};
  if (keeps_published) published_.push_back(seen);
  auto message = publication;
  message.retain = message.retain && retains;
  if (!from->version_5) message.expiry = {};
  const int fault = fault_of(*from, message);
  const bool ignored = matches_any(ignored_topics, message.topic);
  const bool reached = fault != 0 || ignored || spread(message);
  if (message.qos > 0) acknowledge(from, message, reached ? fault : kNoSubscribers);
  if (heard) heard(seen);
}

void MqttBroker::take_will(const MemorySession& from) {
  const auto& will = from.options.will;
  if (!will || (rights && !rights->may_write(from.options.user, will->topic))) return;
  const Publication seen{from.options.client_id, will->topic, will->payload, will->retain, will->qos, true,
                         net_.scheduler().now()};
  if (keeps_published) published_.push_back(seen);
  if (!matches_any(refused_topics, will->topic) && !matches_any(ignored_topics, will->topic))
    spread({will->topic, will->payload, will->retain, will->qos});
  if (heard) heard(seen);
}

void MqttBroker::acknowledge(const SessionPtr& session, const MqttPublication& publication, int reason) {
  if (!acknowledges) return;
  const int told = session->version_5 ? reason : 0;
  if (told >= kRefusal) ++session->counters.not_taken;
  send(session, {[session, topic = publication.topic, number = publication.number, told] {
         const auto& calls = session->calls;
         if (session->lost || !session->alive) return;
         const MqttOutcome outcome{topic, number, static_cast<MqttReason>(told)};
         if (told >= kRefusal && calls.not_taken)
           calls.not_taken(outcome, publication_error(told, session->name, topic));
         else if (told < kRefusal && calls.taken)
           calls.taken(outcome);
       }});
}

void MqttBroker::publish(std::string_view topic, std::string_view payload, bool retain, std::uint8_t qos,
                         Duration expiry) {
  spread({std::string(topic), std::string(payload), retain, qos, MqttQueue::kInOrder, expiry});
}

void MqttBroker::retain(const MqttPublication& publication) {
  const auto& topic = publication.topic;
  expiries_.erase(topic);
  if (publication.payload.empty()) {
    retained_.erase(topic);
    return;
  }
  retained_[topic] = publication.payload;
  if (publication.expiry > Duration::zero())
    expiries_[topic] = net_.scheduler().after(publication.expiry, [this, topic] { retained_.erase(topic); });
}

/// Whether anybody subscribes to it; for mosquitto also who may not read it.
bool MqttBroker::spread(const MqttPublication& publication) {
  if (publication.retain) retain(publication);
  bool anybody = false;
  for (const auto& session : std::vector<SessionPtr>(sessions_)) {
    for (const auto& [filter, qos] : session->filters) {
      if (!mqtt_matches(filter, publication.topic)) continue;
      anybody = true;
      auto message = publication;
      message.qos = std::min(message.qos, qos);
      deliver(session, message, false);
      if (repeats && message.qos == 1) deliver(session, message, false);
    }
  }
  return anybody;
}

void MqttBroker::deliver(const SessionPtr& to, const MqttPublication& message, bool retained) {
  const bool too_long = packet_size(message.topic, message.payload) > to->options.largest_packet;
  if (too_long && to->version_5) return;
  if (rights && !rights->may_read(to->options.user, message.topic)) return;
  if (loses && loses(to->options.client_id, message)) return;
  MemoryPacket packet{{}, !retained || message.qos > 0, message.qos};
  if (message.expiry > Duration::zero()) packet.expires = net_.scheduler().now() + message.expiry;
  packet.arrive = [to, message, retained, too_long] {
    const auto& [topic, payload] = std::tie(message.topic, message.payload);
    if (to->lost || !to->alive || !to->connected) return;
    ++(too_long ? to->counters.too_long : to->counters.received);
    if (too_long && to->calls.too_long) to->calls.too_long(topic, packet_size(topic, payload));
    if (too_long || !to->calls.received) return;
    if (!to->version_5) return to->calls.received({topic, payload, retained});
    to->calls.received({topic, payload, retained, message.expiry, message.response_topic, message.correlation, {}});
  };
  send(to, std::move(packet));
}

/// The line was destroyed.
void MqttBroker::leave(const SessionPtr& session) {
  if ((stalled_ || session->stalled) && session->accepted) return;
  take_in(session);
  session->lost = !session->accepted;
  transit([this, session] { forget(session); });
}

void MqttBroker::forget(const SessionPtr& session) {
  std::erase(sessions_, session);
  session->half_open.cancel();
  session->reading.cancel();
  session->backlog.clear();
  session->filters.clear();
  session->accepted = false;
}

void MqttBroker::drop(const SessionPtr& session, const Error& why, bool with_will) {
  const bool accepted = session->accepted;
  forget(session);
  lose(net_, session, why);
  if (accepted && with_will) take_will(*session);
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
