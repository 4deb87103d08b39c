#include "apps/rubicon/knx/bus.h"

#include <fmt/format.h>

#include <csignal>
#include <cstdlib>
#include <utility>

#include "apps/rubicon/output/tuple_text.h"
#include "base/config_reader.h"
#include "base/text.h"
#include "model/json_members.h"
#include "model/json_text.h"
#include "networks/knx/knx_network.h"
#include "networks/knx/line/discovery.h"
#include "networks/knx/secure/passwords.h"
#include "transport/asio_scheduler.h"
#include "transport/local_transports.h"

namespace rubicon::cli::knx {

std::unique_ptr<ToolLine> open_bus(const Settings& settings, const BusOptions& options, std::string_view command,
                                   int& code) {
  if (!options.direct.empty()) return open_direct(settings, options, code);
  return open_tool_line(settings, command, options.network, kBusTags, code);
}

namespace {

using nlohmann::json;

/// Failures are reported by the state of the line.
base::NullLogSink no_log;

/// A KNX network that runs in this program: this class is its host, and gets its replies.
class DirectBus final : public ToolLine, private network::NetworkHost {
 public:
  DirectBus() : ToolLine(kBusTags), signals_(loop_, {SIGINT, SIGTERM}, [this] { interrupt(); }) {}

  Result<void> open(const BusOptions& options, Duration timeout);

  void send(const json& request) override;
  bool run(const std::function<bool()>& done, Duration patience) override;
  bool interrupted() const override { return interrupted_; }
  void resume() override { interrupted_ = false; }
  Output& out() override { return out_; }

 private:
  using NetworkHost::deliver;
  void deliver(Message&& message) override {
    loop_.scheduler().post([this, message = std::move(message)] { receive(message); });
  }
  Result<void> remember(std::string_view, ByteView, network::Keep) override { return keeps_nothing(); }
  Result<std::optional<Bytes>> remembered(std::string_view) override { return keeps_nothing(); }
  static tl::unexpected<Error> keeps_nothing() {
    return fail(ErrorCode::kUnsupported, "only an island does, with a state file: leave out --direct");
  }
  void failed(Error why) override {
    reason_ = std::move(why.text);
    set_line(false);
    reopen_ = loop_.scheduler().after(std::chrono::seconds(1), [this] { open_network(); });
  }
  void open_network() {
    if (auto opened = network_->open(); !opened) failed(opened.error());
  }
  void set_line(bool up) {
    if (std::exchange(up_, up) != up && on_line) on_line(up, reason_);
  }
  Scheduler& scheduler() override { return loop_.scheduler(); }
  transport::Transports& transports() override { return transports_; }
  const Log& log() const override { return log_; }

  using ToolLine::receive;
  void receive(const Message& message);
  bool tries_again(const model::State& state) const;
  void stop_if_done() {
    out_.flush();
    if (done_() || interrupted_ || out_.broken()) loop_.stop();
  }
  void interrupt() {
    interrupted_ = true;
    loop_.stop();
  }

  transport::Loop loop_;
  transport::LocalTransports transports_{loop_};
  Log log_{no_log, "knx"};
  Output out_{1};
  TypeCatalogue types_;
  bool interrupted_ = false, up_ = false;
  bool hopeless_ = false;  ///< the line is refused, and not tried again while the user waits
  WallTime patience_ends_{};
  std::string reason_ = "no answer";
  std::function<bool()> done_ = [] { return false; };
  transport::Signals signals_;
  Timer reopen_;
  std::unique_ptr<network::Network> network_;
};

/// The options of a KNX network with this tunnel.
ConfigNode tunnel_options(const BusOptions& options, const base::HostPort& server) {
  ConfigNode node;
  node.kind = ConfigNode::Kind::kMap;
  const auto set = [&node](const char* key, std::string text) {
    if (text.empty()) return;
    ConfigNode value;
    value.kind = ConfigNode::Kind::kScalar;
    value.text = std::move(text);
    node.entries.emplace_back(key, std::move(value));
  };
  set("via", options.tcp || !options.keyring.empty() ? "tunnel-tcp" : "tunnel");
  set("host", server.host);
  set("port", std::to_string(server.port));
  set("keyring", options.keyring);
  set("keyring-password-file", options.password_file);
  set("server-address", options.server);
  set("tunnel-address", options.tunnel_address);
  set("group-keys-file", options.group_keys);
  return node;
}

Result<void> DirectBus::open(const BusOptions& options, Duration timeout) {
  const auto server = base::parse_host_port(options.direct, networks::knx::line::kKnxPort);
  if (!server || server->host.empty())
    return fail(ErrorCode::kInvalid,
                fmt::format("--direct is {}, expected HOST or HOST:PORT", model::quoted(options.direct)));
  if (!options.keyring.empty() && options.password_file.empty() &&
      std::getenv(networks::knx::secure::kPasswordVariable) == nullptr)
    return fail(ErrorCode::kInvalid, fmt::format("--keyring needs its password: --password-file FILE, or {}",
                                                 networks::knx::secure::kPasswordVariable));
  const auto node = tunnel_options(options, *server);
  ConfigErrors errors;
  ConfigReader reader(node, "knx", errors);
  auto made = networks::knx::kType.make({"knx", IslandId(1), reader, types_, {}}, *this);
  if (!made) return fail(ErrorCode::kInvalid, errors.empty() ? made.error().text : errors.text());
  network_ = std::move(*made);
  open_network();
  patience_ends_ = loop_.scheduler().wall_now() + std::chrono::ceil<std::chrono::microseconds>(timeout);
  run([this] { return up_ || hopeless_; }, timeout);
  if (up_) return {};
  return fail(ErrorCode::kUnreachable, fmt::format("no tunnel to {}: {}", options.direct, reason_));
}

/// While the user still waits.
bool DirectBus::tries_again(const model::State& state) const {
  const auto next = state.counters.find("next-attempt");
  return next != state.counters.end() && next->second != 0 &&
         WallTime(std::chrono::seconds(next->second)) < patience_ends_;
}

void DirectBus::send(const json& request) {
  Message message;
  message.source.island = IslandId(1);
  const auto text = model::dump(request);
  const auto bytes = base::as_bytes(text);
  message.body = model::Opaque{std::string(networks::knx::kRequestTag), Bytes(bytes.begin(), bytes.end())};
  if (auto accepted = network_->send(message); !accepted && on_reply)
    on_reply({{"id", model::text_of(request, "id")}, {"ok", false}, {"why", accepted.error().text}});
}

void DirectBus::receive(const Message& message) {
  if (const auto* opaque = std::get_if<model::Opaque>(&message.body)) {
    receive(opaque->type, base::as_text(opaque->bytes));
  } else if (const auto* state = std::get_if<model::State>(&message.body)) {
    const bool up = state->line == model::LineState::kUp;
    if (!up && !state->reason.empty()) reason_ = state->reason;
    hopeless_ = state->line == model::LineState::kRefused && !tries_again(*state);
    set_line(up);
  }
  stop_if_done();
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

std::unique_ptr<ToolLine> open_direct(const Settings& settings, const BusOptions& options, int& code) {
  auto bus = std::make_unique<DirectBus>();
  const auto opened = bus->open(options, std::max<Duration>(settings.patience, std::chrono::seconds(12)));
  if (opened) return bus;
  print_error(opened.error().text);
  code = opened.error().code == ErrorCode::kInvalid ? kUsage : kFailed;
  return nullptr;
}

}  // namespace rubicon::cli::knx
