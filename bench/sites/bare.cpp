#include <fmt/format.h>
#include <mosquitto.h>

#include <chrono>
#include <memory>
#include <thread>

#include "components/windows.h"
#include "sites/broker.h"
#include "sites/engine.h"
#include "sites/measurements.h"
#include "tuples/mqtt/channel.h"

namespace rubicon::bench::sites {

namespace {

constexpr int kKeepAlive = 60, kLoopMs = 100;

/// As long as the frame that brings a value.
std::string payload_of_set() {
  tuples::distant::FrameWriter entries;
  const Duration now = std::chrono::hours(100);
  entries.add(tuples::distant::FrameTimes{now, now, std::chrono::milliseconds(1), false});
  tuples::TupleView tuple;
  const auto value = value_of(0);
  tuple.owner = tuple.creator = kFirst;
  tuple.key = "bench.ping";
  tuple.value = value;
  tuple.media_type = "text/plain";
  tuple.sequence = 10'000;
  tuple.write_time = std::chrono::floor<WallTime::duration>(std::chrono::system_clock::now());
  entries.add(tuples::TupleSet{tuple});
  tuples::mqtt::FrameHead head;
  head.source = kFirst;
  head.target = kSecond;
  head.source_incarnation = head.target_incarnation = 1'800'000'000'000'000;
  head.stream = head.heard_stream = 360'000'000'000;
  head.number = head.first = head.heard = 10'000;
  head.credit = tuples::mqtt::Channel::kMaxCredit;
  return std::string(base::as_text(tuples::mqtt::frame_of(head, entries.view())));
}

/// A client of libmosquitto and nothing else, in this thread.
class BareClient {
 public:
  BareClient(const Meeting& meeting, const std::string& own, const std::string& other)
      : inbox_(topic_of(meeting, own, other)), outbox_(topic_of(meeting, other, own)) {
    ::mosquitto_lib_init();
    client_ = ::mosquitto_new(nullptr, true, this);
    ::mosquitto_int_option(client_, MOSQ_OPT_TCP_NODELAY, 1);
    if (!meeting.trust.empty()) secure(meeting.trust);
    ::mosquitto_message_callback_set(
        client_, [](mosquitto*, void* self, const mosquitto_message*) { ++static_cast<BareClient*>(self)->heard_; });
    ::mosquitto_subscribe_callback_set(client_, [](mosquitto*, void* self, int, int, const int*) {
      static_cast<BareClient*>(self)->subscribed_ = true;
    });
    must(::mosquitto_connect(client_, "127.0.0.1", port_of(meeting), kKeepAlive));
    must(::mosquitto_subscribe(client_, nullptr, inbox_.c_str(), 0));
    while (!subscribed_) must(::mosquitto_loop(client_, kLoopMs, 1));
  }
  ~BareClient() {
    ::mosquitto_disconnect(client_);
    ::mosquitto_destroy(client_);
  }
  BareClient(const BareClient&) = delete;
  BareClient& operator=(const BareClient&) = delete;

  void send() {
    must(::mosquitto_publish(client_, nullptr, outbox_.c_str(), static_cast<int>(payload_.size()), payload_.data(), 0,
                             false));
  }
  /// Until there is one more; false: not within this time.
  bool await(Duration patience = std::chrono::seconds(10)) {
    const auto until = Clock::now() + patience;
    const auto before = heard_;
    while (heard_ == before && Clock::now() < until) must(::mosquitto_loop(client_, kLoopMs, 1));
    return heard_ > before;
  }
  /// Until the connection ends.
  void answer_all() {
    for (std::uint64_t answered = 0; ::mosquitto_loop(client_, kLoopMs, 1) == MOSQ_ERR_SUCCESS;) {
      for (; answered < heard_; ++answered) send();
    }
  }

 private:
  /// As long as the inbox of a component here.
  static std::string topic_of(const Meeting& meeting, const std::string& to, const std::string& from) {
    const auto user = meeting.trust.empty() ? "-" : kUser;
    return fmt::format("rubicon-space/1/{}/to/{}/{:0<12}/{}/{:0<12}", meeting.tag, user, to, user, from);
  }
  static void must(int code) {
    if (code != MOSQ_ERR_SUCCESS) give_up(fmt::format("libmosquitto: {}", ::mosquitto_strerror(code)));
  }
  void secure(const std::string& folder) {
    const auto ca = folder + "ca.pem", certificate = folder + "client.pem", key = folder + "client.key";
    must(::mosquitto_tls_set(client_, ca.c_str(), nullptr, certificate.c_str(), key.c_str(), nullptr));
    must(::mosquitto_tls_insecure_set(client_, true));  // its certificate has another name than this address
  }

  std::string inbox_, outbox_, payload_ = payload_of_set();
  mosquitto* client_ = nullptr;
  bool subscribed_ = false;
  std::uint64_t heard_ = 0;
};

}  // namespace

Json bare_pong(const Meeting& meeting, const Json&) {
  BareClient(meeting, "b", "a").answer_all();
  return Json::object();
}

Json bare_ping(const Meeting& meeting, const Json& options) {
  BareClient client(meeting, "a", "b");
  const auto pace = std::chrono::microseconds(options.at("pace_us").get<int>());
  const auto seconds = options.at("seconds").get<double>() + 1;
  do client.send();
  while (!client.await(std::chrono::milliseconds(200)));
  while (client.await(std::chrono::milliseconds(200))) continue;  // of what was sent before the other one was there
  Windows windows;
  auto now = Clock::now();
  windows.begin(now);
  while (windows.seconds(now) <= seconds) {
    const auto sent = Clock::now();
    client.send();
    if (!client.await()) give_up("the other end of a bare connection is gone");
    now = Clock::now();
    windows.add(sent, now);
    if (pace.count() > 0) std::this_thread::sleep_until(sent + pace);
  }
  return windows.json();
}

}  // namespace rubicon::bench::sites
