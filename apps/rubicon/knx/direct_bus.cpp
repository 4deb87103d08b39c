#include "apps/rubicon/knx/direct_bus.h"

#include <fmt/format.h>

#include <csignal>
#include <utility>

#include "apps/rubicon/tuple_text.h"
#include "base/config_reader.h"
#include "model/json_members.h"
#include "networks/knx/knx_network.h"
#include "networks/knx/tool_requests.h"
#include "transport/asio_scheduler.h"
#include "transport/asio_signals.h"
#include "transport/local_transports.h"

namespace rubicon::cli::knx {

namespace {

using nlohmann::json;

/// Failures show in the state of the line.
base::NullLogSink no_log;

/// A KNX network without an island: the same code, its answers come here.
class DirectBus final : public Bus, private network::NetworkHost {
 public:
  DirectBus() : signals_(loop_, {SIGINT, SIGTERM}, [this] { interrupt(); }) {}
  DirectBus(const DirectBus&) = delete;
  DirectBus& operator=(const DirectBus&) = delete;

  Result<void> open(const BusOptions& options, Duration patience);

  void ask(const json& request) override;
  bool run(const std::function<bool()>& done, Duration patience) override;
  bool interrupted() const override { return interrupted_; }
  Output& out() override { return out_; }

 private:
  using NetworkHost::deliver;
  void deliver(Message message) override {
    loop_.scheduler().post([this, message = std::move(message)] { hear(message); });
  }
  void failed(Error why) override {
    reason_ = std::move(why.text);
    line_is(false);
    again_ = loop_.scheduler().after(std::chrono::seconds(1), [this] { try_to_open(); });
  }
  void try_to_open() {
    if (auto opened = network_->open(); !opened) failed(opened.error());
  }
  void line_is(bool up) {
    if (std::exchange(up_, up) != up && on_line) on_line(up, reason_);
  }
  Scheduler& scheduler() override { return loop_.scheduler(); }
  transport::Transports& transports() override { return lines_; }
  const Log& log() const override { return log_; }

  void hear(const Message& message);
  void look() {
    out_.flush();
    if (done_() || interrupted_ || out_.broken()) loop_.stop();
  }
  void interrupt() {
    interrupted_ = true;
    loop_.stop();
  }

  transport::Loop loop_;
  transport::LocalTransports lines_{loop_};
  Log log_{no_log, "knx"};
  Output out_{1};
  TypeCatalogue types_;
  bool interrupted_ = false, up_ = false;
  std::string reason_ = "no answer";
  std::function<bool()> done_ = [] { return false; };
  transport::Signals signals_;
  Timer again_;
  std::unique_ptr<network::Network> network_;
};

Result<void> DirectBus::open(const BusOptions& options, Duration patience) {
  ConfigNode node;
  node.kind = ConfigNode::Kind::kMap;
  const auto set = [&node](const char* key, std::string text) {
    ConfigNode value;
    value.kind = ConfigNode::Kind::kScalar;
    value.text = std::move(text);
    node.entries.emplace_back(key, std::move(value));
  };
  set("via", options.tcp ? "tunnel-tcp" : "tunnel");
  const auto colon = options.direct.find(':');
  set("host", options.direct.substr(0, colon));
  if (colon != options.direct.npos) set("port", options.direct.substr(colon + 1));
  ConfigErrors errors;
  ConfigReader reader(node, "knx", errors);
  auto made = networks::knx::kType.make({"knx", IslandId(1), reader, types_, {}}, *this);
  if (!made) return fail(ErrorCode::kInvalid, errors.empty() ? made.error().text : errors.text());
  network_ = std::move(*made);
  try_to_open();
  if (run([this] { return up_; }, patience)) return {};
  return fail(ErrorCode::kUnreachable, fmt::format("no tunnel to {}: {}", options.direct, reason_));
}

void DirectBus::ask(const json& request) {
  Message message;
  message.source.island = IslandId(1);
  const auto text = request.dump();
  const auto bytes = base::as_bytes(text);
  message.body = model::Opaque{std::string(networks::knx::kRequestTag), Bytes(bytes.begin(), bytes.end())};
  if (auto taken = network_->send(message); !taken && on_reply)
    on_reply({{"id", model::text_of(request, "id")}, {"ok", false}, {"why", taken.error().text}});
}

void DirectBus::hear(const Message& message) {
  if (const auto* opaque = std::get_if<model::Opaque>(&message.body)) {
    take(opaque->type, base::as_text(opaque->bytes));
  } else if (const auto* state = std::get_if<model::State>(&message.body)) {
    const bool up = state->line == model::LineState::kUp;
    if (!up && !state->reason.empty()) reason_ = state->reason;
    line_is(up);
  }
  look();
}

bool DirectBus::run(const std::function<bool()>& done, Duration patience) {
  done_ = done;
  out_.flush();
  if (done()) return true;
  Timer end;
  if (patience != Duration::max()) end = loop_.scheduler().after(patience, [this] { loop_.stop(); });
  loop_.run();
  done_ = [] { return false; };
  return done();
}

}  // namespace

std::unique_ptr<Bus> open_direct(const Settings& settings, const BusOptions& options, int& code) {
  auto bus = std::make_unique<DirectBus>();
  const auto opened = bus->open(options, std::max<Duration>(settings.patience, std::chrono::seconds(12)));
  if (opened) return bus;
  print_error(opened.error().text);
  code = opened.error().code == ErrorCode::kInvalid ? kUsage : kFailed;
  return nullptr;
}

}  // namespace rubicon::cli::knx
