#include "transport/mosquitto_client.h"

#include <fmt/format.h>
#include <mosquitto.h>
#include <mqtt_protocol.h>
#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <map>
#include <span>
#include <utility>

#include "base/text.h"
#include "transport/mosquitto_faults.h"
#include "transport/mqtt.h"
#include "transport/mqtt_batch.h"
#include "transport/mqtt_tls.h"

namespace rubicon::transport {

namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using Clock = std::chrono::steady_clock;

/// What goes through in one turn, before the other directions get theirs.
constexpr int kReadsPerTurn = 256;
constexpr std::size_t kBytesPerTurn = std::size_t{256} * 1024;
/// Publications of QoS 1 without an answer.
constexpr std::size_t kMaxUnacknowledged = 100;
/// Filters of one SUBSCRIBE, in bytes.
constexpr std::size_t kFiltersAtOnce = std::size_t{8} * 1024;
/// For what waits, once the line was destroyed.
constexpr auto kLeavingTime = seconds(1);
constexpr int kBadVersion5 = 0x84;

/// One connection with one version of the protocol.
class MosquittoClient {
 public:
  enum class End : std::uint8_t { kDone, kOldVersionNeeded };

  MosquittoClient(const MqttOptions& options, MqttExchange& exchange, bool version_5)
      : options_(options), exchange_(exchange), version_5_(version_5), name_(mqtt_name(options)), faults_(options) {}
  ~MosquittoClient() {
    ::mosquitto_destroy(client_);
    if (faults_.accepted) exchange_.home().connected(false);
  }
  MosquittoClient(const MosquittoClient&) = delete;
  MosquittoClient& operator=(const MosquittoClient&) = delete;

  End run() {
    if (auto begun = begin(); !begun) {
      fail_with(begun.error());
    } else {
      while (!over_) turn();
    }
    return end_;
  }

 private:
  struct Unacknowledged {
    std::string topic;
    std::uint64_t number = 0;
    Clock::time_point since;
  };
  struct Asked {
    std::vector<MqttAsk> asks;
    Clock::time_point since;
  };

  static MosquittoClient& self(void* user) { return *static_cast<MosquittoClient*>(user); }

  Result<void> begin() {
    client_ = ::mosquitto_new(options_.client_id.c_str(), true, this);
    if (client_ == nullptr) return fail(ErrorCode::kIo, fmt::format("{}: no memory or descriptors", name_));
    ::mosquitto_int_option(client_, MOSQ_OPT_PROTOCOL_VERSION, version_5_ ? MQTT_PROTOCOL_V5 : MQTT_PROTOCOL_V311);
    ::mosquitto_int_option(client_, MOSQ_OPT_TCP_NODELAY, 1);
    ::mosquitto_int_option(client_, MOSQ_OPT_SEND_MAXIMUM, static_cast<int>(kMaxUnacknowledged));
    ::mosquitto_threaded_set(client_, true);  // it writes in mosquitto_loop_write() only
    if (!options_.user.empty())
      ::mosquitto_username_pw_set(client_, options_.user.c_str(),
                                  options_.password.empty() ? nullptr : options_.password.c_str());
    if (const auto& will = options_.will)
      ::mosquitto_will_set(client_, will->topic.c_str(), static_cast<int>(will->payload.size()), will->payload.data(),
                           will->qos, will->retain);
    set_calls();
    if (auto right = begin_tls(); !right) return right;
    return connect();
  }

  Result<void> begin_tls() {
    if (!options_.tls) return {};
    auto made = MqttTlsContext::make(*options_.tls, options_.host);
    if (!made) return fail(made.error().code, fmt::format("{}: {}", name_, made.error().text));
    tls_ = std::move(*made);
    faults_.tls = tls_.get();
    // The library reports why TLS fails nowhere else. With this call it formats a line for each packet.
    ::mosquitto_log_callback_set(client_, [](auto*, void* user, int level, const char* text) {
      if (level == MOSQ_LOG_ERR && self(user).faults_.complaint.empty()) self(user).faults_.complaint = text;
    });
    ::mosquitto_void_option(client_, MOSQ_OPT_SSL_CTX, tls_->get());
    ::mosquitto_int_option(client_, MOSQ_OPT_SSL_CTX_WITH_DEFAULTS, 0);
    return {};
  }

  void set_calls() {
    ::mosquitto_connect_v5_callback_set(client_, [](auto*, void* user, int code, int, const auto* properties) {
      self(user).on_connack(code, properties);
    });
    ::mosquitto_disconnect_v5_callback_set(
        client_, [](auto*, void* user, int reason, const auto*) { self(user).on_disconnect(reason); });
    ::mosquitto_message_v5_callback_set(client_, [](auto*, void* user, const auto* message, const auto* properties) {
      self(user).on_message(*message, properties);
    });
    ::mosquitto_subscribe_callback_set(client_, [](auto*, void* user, int id, int count, const int* granted) {
      self(user).on_suback(id, count, granted);
    });
    ::mosquitto_publish_v5_callback_set(
        client_, [](auto*, void* user, int id, int reason, const auto*) { self(user).on_published(id, reason); });
  }

  /// Blocks: looks the name up and connects.
  Result<void> connect() {
    const auto properties = version_5_ ? connect_properties(options_) : nullptr;
    // The library sends a PINGREQ after this time, and waits as long for the answer.
    const auto quiet = std::chrono::floor<seconds>(options_.keep_alive).count();
    const int result = ::mosquitto_connect_bind_v5(client_, options_.host.c_str(), options_.port,
                                                   static_cast<int>(quiet), nullptr, properties.get());
    const int error = errno;
    if (result == MOSQ_ERR_SUCCESS) {
      exchange_.answered = true;
      return {};
    }
    return fail(faults_.of_connect(result, error));
  }

  void turn() {
    const int socket = ::mosquitto_socket(client_);
    const bool reads = exchange_.may_read();
    const int wanted = (reads ? POLLIN : 0) | (has_written() ? 0 : POLLOUT);
    pollfd ready[] = {{exchange_.wake_descriptor(), POLLIN, 0},
                      {wanted == 0 ? -1 : socket, static_cast<short>(wanted), 0}};
    ::poll(ready, 2, static_cast<int>(milliseconds(timeout()).count()));
    if (ready[0].revents != 0) exchange_.clear_wake();
    if (exchange_.dismissed() && !leave_at_) begin_leaving();
    const bool more = ready[1].revents != 0 || tls_;  // bytes may wait inside OpenSSL
    if (reads && more && !over_) read();
    if ((ready[1].revents & POLLOUT) != 0 && !over_) write();
    if (!over_) send();
    if (!over_) check(::mosquitto_loop_misc(client_));
    if (!over_) write();
    if (!over_ && !leave_at_) look_for_answers();
    tell();
  }

  /// mosquitto 2.0 drops its answers too, for a client that did not read for a while.
  void look_for_answers() {
    const auto now = Clock::now();
    if (now < next_look_) return;
    next_look_ = now + seconds(1);
    if (!has_written()) written_ = now;
    const auto late = [&](const auto& asked) { return std::max(asked.second.since, written_) + 2 * keep_alive_ < now; };
    if (std::any_of(asked_.begin(), asked_.end(), late)) fail_with(faults_.no_answer("a subscription"));
    if (!over_ && std::any_of(unacknowledged_.begin(), unacknowledged_.end(), late))
      fail_with(faults_.no_answer("a publication"));
  }

  milliseconds timeout() const { return leave_at_ ? milliseconds(20) : milliseconds(1000); }

  /// Until nothing comes, or the loop has enough to do.
  void read() {
    // The library takes the end of a connection during the TLS handshake for nothing, again and again.
    if (!faults_.accepted && is_ended(::mosquitto_socket(client_))) return check(MOSQ_ERR_CONN_LOST);
    std::size_t bytes = 0;
    for (int i = 0; i < kReadsPerTurn && bytes < kBytesPerTurn && !over_; ++i) {
      heard_ = 0;
      check(::mosquitto_loop_read(client_, 1));
      if (heard_ == 0) break;
      bytes += heard_;
    }
    acknowledge_now(::mosquitto_socket(client_));
  }

  bool has_written() const { return batch_.empty() && !::mosquitto_want_write(client_); }

  /// Packets of the library and those of the batch must not mix within one.
  void write() {
    if (!batch_.empty() && !batch_.write(::mosquitto_socket(client_), ::mosquitto_ssl_get(client_)))
      return check(tls_ ? MOSQ_ERR_TLS : errno == ECONNRESET || errno == EPIPE ? MOSQ_ERR_CONN_LOST : MOSQ_ERR_ERRNO);
    if (batch_.empty() && ::mosquitto_want_write(client_)) check(::mosquitto_loop_write(client_, 1));
  }

  void send() {
    if (!faults_.accepted) return;
    bool drained = false;
    for (bool more = true; more && !over_;) {
      std::optional<std::size_t> room;
      if (has_written()) room = most_unacknowledged_ - std::min(most_unacknowledged_, unacknowledged_.size());
      exchange_.take_work(room, work_);
      more = !work_.empty();
      drained = !more && room;
      send_asks(work_.asks);
      for (const auto& message : work_.publications) publish(message);
      if (!over_) write();
    }
    if (leave_at_ && !over_) leave(drained);
  }

  void publish(const MqttPublication& message) {
    if (over_) return;
    if (message.qos == 0) {
      ++(batch_.add(message, limits_) ? exchange_.sent : exchange_.not_taken);
      return;
    }
    int id = 0;
    const auto properties = version_5_ ? publish_properties(message) : nullptr;
    const int result =
        ::mosquitto_publish_v5(client_, &id, message.topic.c_str(), static_cast<int>(message.payload.size()),
                               message.payload.data(), message.qos, message.retain, properties.get());
    if (is_end(result)) return check(result);
    ++(result == MOSQ_ERR_SUCCESS ? exchange_.sent : exchange_.not_taken);
    if (result == MOSQ_ERR_SUCCESS)
      unacknowledged_[id] = {message.topic, message.number, Clock::now()};
    else
      not_taken({message.topic, message.number, {}}, MqttReason::kUnspecified,
                {ErrorCode::kInvalid,
                 fmt::format("{}: cannot publish to {}: {}", name_, message.topic, ::mosquitto_strerror(result))});
  }

  void not_taken(const Unacknowledged& what, MqttReason reason, Error why) {
    events_.push_back({MqttEvent::Kind::kNotTaken, what.topic, {}, false, reason, what.number, std::move(why)});
  }

  /// Results of a request to the library that mean the end of the connection; all others concern the request.
  static bool is_end(int result) {
    return result == MOSQ_ERR_CONN_LOST || result == MOSQ_ERR_NO_CONN || result == MOSQ_ERR_ERRNO ||
           result == MOSQ_ERR_TLS;
  }

  /// Sends requests in their order. Requests of one kind that follow each other share a packet, as far as they fit.
  void send_asks(std::vector<MqttAsk>& asks) {
    constexpr std::size_t kLengthAndOptions = 3;
    for (auto first = asks.begin(); first != asks.end() && !over_;) {
      auto end = first;
      std::size_t bytes = 0;
      do {
        bytes += (end++)->filter.size() + kLengthAndOptions;
      } while (end != asks.end() && end->qos == first->qos && end->wanted == first->wanted &&
               bytes + end->filter.size() + kLengthAndOptions <= filters_at_once_);
      send_together({first, end});
      first = end;
    }
  }

  /// A request that the library rejects is refused. It never ends the connection: the next connection would end as
  /// well.
  void send_together(std::span<MqttAsk> asks) {
    if (over_) return;
    std::vector<char*> filters;
    for (auto& ask : asks) filters.push_back(ask.filter.data());
    const auto count = static_cast<int>(filters.size());
    const auto& first = asks.front();
    int id = 0;
    const int result = first.wanted
                           ? ::mosquitto_subscribe_multiple(client_, &id, count, filters.data(), first.qos, 0, nullptr)
                           : ::mosquitto_unsubscribe_multiple(client_, &id, count, filters.data(), nullptr);
    if (result == MOSQ_ERR_SUCCESS || is_end(result)) {
      if (first.wanted) {
        asked_[id] = {std::vector<MqttAsk>(asks.begin(), asks.end()), Clock::now()};
      } else {
        for (auto& ask : asks) exchange_.answered_ask(ask);
      }
      return check(result);
    }
    if (asks.size() == 1) {
      exchange_.answered_ask(first);
      return refuse(first, ::mosquitto_strerror(result));
    }
    for (auto& ask : asks) send_together({&ask, 1});
  }

  void refuse(const MqttAsk& ask, const char* why) {
    if (!ask.wanted) return;
    Error error{ErrorCode::kRefused,
                fmt::format("{}: cannot subscribe to {}: {}", name_, base::one_line(ask.filter.substr(0, 100)), why)};
    events_.push_back({.kind = MqttEvent::Kind::kRefused, .topic = ask.filter, .why = std::move(error)});
  }

  void begin_leaving() {
    leave_at_ = Clock::now() + kLeavingTime;
    if (!faults_.accepted) over_ = true;
  }

  /// When everything is sent, or its time is over.
  void leave(bool drained) {
    if (!drained && Clock::now() < *leave_at_) return;
    const KeptSocket kept(::mosquitto_socket(client_));
    if (batch_.empty()) {
      ::mosquitto_disconnect(client_);
      ::mosquitto_loop_write(client_, 1);
    }
    over_ = true;
    kept.await_end(*leave_at_);
  }

  void on_connack(int code, const mosquitto_property* properties) {
    heard_ += 1;
    const int reason = version_5_ ? code : reason_of_return_code(code);
    if (reason != 0) {
      faults_.reason = reason;
      return;
    }
    faults_.accepted = true;
    exchange_.home().connected(true);
    most_unacknowledged_ = std::min(read_receive_maximum(properties), kMaxUnacknowledged);
    MqttEvent event;
    event.kind = MqttEvent::Kind::kConnected;
    event.connack = std::make_unique<MqttConnack>(read_connack(properties, version_5_, options_.keep_alive));
    const auto largest = event.connack->largest_packet;
    limits_ = {version_5_, event.connack->retains, largest};
    keep_alive_ = event.connack->keep_alive;
    constexpr std::size_t kHeader = 1 + 4, kPacketId = 2, kProperties = 1;
    if (largest > 0)
      filters_at_once_ = std::min(kFiltersAtOnce, largest - std::min(largest, kHeader + kPacketId + kProperties));
    events_.push_back(std::move(event));
  }

  void on_message(const mosquitto_message& message, const mosquitto_property* properties) {
    const auto bytes = static_cast<std::size_t>(message.payloadlen);
    heard_ += bytes + 1;
    const std::string_view topic = message.topic;
    const std::string_view payload(static_cast<const char*>(message.payload), bytes);
    if (packet_size(topic, payload) > options_.largest_packet) {
      ++exchange_.too_long;
      const auto size = packet_size(topic, payload);
      events_.push_back({.kind = MqttEvent::Kind::kTooLong, .topic = std::string(topic), .number = size});
      return;
    }
    events_.push_back({MqttEvent::Kind::kReceived, std::string(topic), std::string(payload), message.retain});
    events_.back().about = read_about(properties);
  }

  void on_suback(int id, int count, const int* granted) {
    heard_ += 1;
    const auto asked = asked_.extract(id);
    if (asked.empty()) return;
    const auto& asks = asked.mapped().asks;
    for (int i = 0; i < count && i < static_cast<int>(asks.size()); ++i) {
      const auto& ask = asks[static_cast<std::size_t>(i)];
      exchange_.answered_ask(ask);
      granted[i] < 0x80 ? subscribed(ask.filter) : refused(ask.filter, granted[i]);
    }
  }

  void subscribed(const std::string& filter) {
    events_.push_back({.kind = MqttEvent::Kind::kSubscribed, .topic = filter});
  }

  void refused(const std::string& filter, int reason) {
    Error why{ErrorCode::kRefused, fmt::format("{}: the broker refuses to send {} (reason {:#04x})", name_, filter,
                                               static_cast<unsigned>(reason))};
    events_.push_back({.kind = MqttEvent::Kind::kRefused, .topic = filter, .why = std::move(why)});
  }

  void on_published(int id, int reason) {
    heard_ += 1;
    const auto published = unacknowledged_.extract(id);
    if (reason >= 0x80) ++exchange_.not_taken;
    if (published.empty()) return;
    const auto& what = published.mapped();
    const auto told = static_cast<MqttReason>(reason);
    if (reason >= 0x80) return not_taken(what, told, publication_error(reason, name_, what.topic));
    events_.push_back({MqttEvent::Kind::kTaken, what.topic, {}, false, told, what.number});
  }

  /// The library also calls this with its own codes after a reason of the broker.
  void on_disconnect(int reason) {
    if (faults_.reason < 0x80) faults_.reason = reason;
  }

  void tell() {
    auto events = std::exchange(events_, {});
    if (!exchange_.dismissed()) exchange_.tell(std::move(events));
  }

  /// Ends the connection if the library says so.
  void check(int result) {
    const int error = errno;
    if (over_ || (result == MOSQ_ERR_SUCCESS && ::mosquitto_socket(client_) >= 0)) return;
    if (result == MOSQ_ERR_OVERSIZE_PACKET || leave_at_) {
      over_ = leave_at_.has_value();
      return;
    }
    const bool closed_silently = result != MOSQ_ERR_KEEPALIVE && faults_.reason < 0x80 && !faults_.of_tls();
    const bool other_version = faults_.reason == kBadVersion5 || closed_silently;
    if (version_5_ && !faults_.accepted && other_version && options_.version == MqttVersion::kAny) {
      end_ = End::kOldVersionNeeded;
      over_ = true;
      return;
    }
    fail_with(faults_.of_end(result, error));
  }

  void fail_with(Error why) {
    over_ = true;
    MqttEvent event;
    event.kind = MqttEvent::Kind::kFailed;
    event.why = std::move(why);
    events_.push_back(std::move(event));
    tell();
  }

  const MqttOptions& options_;
  MqttExchange& exchange_;
  bool version_5_;
  std::string name_;
  std::unique_ptr<MqttTlsContext> tls_;
  MosquittoFaults faults_;
  mosquitto* client_ = nullptr;
  std::map<int, Asked> asked_;  ///< by the number of their SUBSCRIBE
  std::vector<MqttEvent> events_;
  MqttBatch batch_;
  MqttBatch::Limits limits_;
  MqttWork work_;
  std::map<int, Unacknowledged> unacknowledged_;  ///< publications of QoS 1 by their packet identifiers
  /// What waits beyond it in the library would be overtaken by QoS 0.
  std::size_t most_unacknowledged_ = kMaxUnacknowledged;
  std::size_t filters_at_once_ = kFiltersAtOnce;  ///< bytes of filters that the broker takes in one SUBSCRIBE
  std::size_t heard_ = 0;                         ///< bytes, about, of the last call to the library
  Duration keep_alive_{};
  Clock::time_point next_look_{}, written_{};  ///< for late answers; when something waited to be written
  std::optional<Clock::time_point> leave_at_;
  bool over_ = false;
  End end_ = End::kDone;
};

}  // namespace

void run_mosquitto(const MqttOptions& options, MqttExchange& exchange) {
  bool version_5 = options.version != MqttVersion::k311;
  while (!exchange.dismissed()) {
    MosquittoClient client(options, exchange, version_5);
    if (client.run() == MosquittoClient::End::kDone) return;
    version_5 = false;
  }
}

}  // namespace rubicon::transport
