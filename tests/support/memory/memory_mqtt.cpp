#include "support/memory/memory_mqtt.h"

#include <fmt/format.h>

#include <limits>
#include <utility>

#include "transport/mqtt.h"

namespace rubicon::transport {

using SessionPtr = std::shared_ptr<MemorySession>;

namespace {

constexpr std::size_t kNoLimit = std::numeric_limits<std::size_t>::max();

}  // namespace

class MemoryMqttLine final : public MqttLine {
 public:
  MemoryMqttLine(MemoryNet& net, SessionPtr session) : net_(net), session_(std::move(session)) {}
  ~MemoryMqttLine() override {
    session_->alive = false;
    session_->deadline.cancel();
    session_->lookup.reset();
    if (session_->broker != nullptr) session_->broker->leave(session_);
  }
  MemoryMqttLine(const MemoryMqttLine&) = delete;
  MemoryMqttLine& operator=(const MemoryMqttLine&) = delete;

  Result<void> subscribe(std::string_view filter, std::uint8_t qos) override {
    if (auto right = check_filter(filter, qos, session_->name); !right) return right;
    ask([filter = std::string(filter), qos](const auto& session) { session->broker->subscribe(session, filter, qos); });
    return {};
  }
  Result<void> unsubscribe(std::string_view filter) override {
    if (auto right = check_filter(filter, 0, session_->name); !right) return right;
    ask([filter = std::string(filter)](const auto& session) { session->filters.erase(filter); });
    return {};
  }
  Result<void> publish(MqttPublication publication) override {
    if (!session_->connected)
      return fail(ErrorCode::kUnreachable, fmt::format("{}: cannot publish: not connected", session_->name));
    const bool told = session_->version_5 && session_->broker != nullptr;
    const auto largest = told ? session_->broker->largest_packet : kNoLimit;
    if (auto right = check_publication(publication, largest, session_->name); !right) return right;
    if (auto queued = session_->queue.push(std::move(publication), session_->name); !queued) return queued;
    flush();
    return {};
  }
  MqttCounters counters() const override { return session_->counters; }

  static void reach(MemoryNet& net, const SessionPtr& session, const Result<std::vector<std::string>>& addresses) {
    session->lookup.reset();
    if (!addresses) return lose(net, session, {addresses.error().code, session->name + ": " + addresses.error().text});
    for (const auto& address : *addresses) {
      const auto found = net.brokers.find({address, session->options.port});
      if (found != net.brokers.end()) return found->second->connect(session);
    }
    lose(net, session, {ErrorCode::kUnreachable, session->name + ": cannot connect: Connection refused"});
  }
  static void give_up(MemoryNet& net, const SessionPtr& session) {
    if (session->broker != nullptr) session->broker->forget(session);
    const auto waited = std::chrono::duration<double>(session->options.connect_time).count();
    lose(net, session, {ErrorCode::kUnreachable, fmt::format("{}: no answer within {} s", session->name, waited)});
  }

 private:
  void ask(std::function<void(const SessionPtr&)> call) {
    session_->asked.push_back(std::move(call));
    flush();
  }
  void flush() {
    if (std::exchange(session_->flushing, true)) return;
    net_.scheduler().post([session = session_] {
      session->flushing = false;
      if (session->alive && session->connected && session->broker != nullptr) session->broker->take_in(session);
    });
  }

  MemoryNet& net_;
  SessionPtr session_;
};

void lose(MemoryNet& net, const SessionPtr& session, Error why) {
  if (std::exchange(session->lost, true)) return;
  session->connected = false;
  session->broker = nullptr;
  session->deadline.cancel();
  session->silence.cancel();
  session->backlog.clear();
  net.scheduler().post([session, why = std::move(why)] {
    if (session->alive && session->calls.failed) session->calls.failed(why);
  });
}

Result<std::unique_ptr<MqttLine>> open_memory_mqtt(MemoryNet& net, const MqttOptions& options, MqttCallbacks calls) {
  if (auto right = check_options(options); !right) return fail(right.error());
  static int made = 0;
  auto session = std::make_shared<MemorySession>(options, std::move(calls));
  if (options.client_id.empty()) session->options.client_id = fmt::format("rubicon{}", ++made);
  session->name = mqtt_name(options);
  session->lookup = net.look_up(options.host, [&net, weak = std::weak_ptr(session)](const auto& addresses) {
    if (const auto found = weak.lock()) MemoryMqttLine::reach(net, found, addresses);
  });
  session->deadline = net.scheduler().after(options.connect_time, [&net, weak = std::weak_ptr(session)] {
    if (const auto late = weak.lock()) MemoryMqttLine::give_up(net, late);
  });
  return std::make_unique<MemoryMqttLine>(net, std::move(session));
}

}  // namespace rubicon::transport
