#include "apps/simulators/knx/simulator.h"

#include <fmt/format.h>

#include <utility>

#include "base/bytes.h"
#include "networks/knx/wire/cemi.h"

namespace rubicon::knx_simulator {

namespace {

using namespace std::chrono_literals;
using namespace networks::knx::wire;
using namespace networks::knx::line;

/// Telegrams that wait longer for their turn on the multicast group are discarded.
constexpr Duration kRoutingWait = 5s;
constexpr Duration kRetry = 1s;

std::string text_of(const Telegram& telegram) {
  const auto what = telegram.service == Service::kRead    ? "read"
                    : telegram.service == Service::kWrite ? "write"
                                                          : "response";
  return fmt::format("{} {} {} {}", to_string(telegram.source), what, to_string(telegram.destination),
                     base::to_hex(telegram.payload.bytes));
}

ServerOptions server_options(const SimulatorOptions& options) {
  auto server = options.server;
  server.shares_port = options.routing.has_value();
  return server;
}

}  // namespace

Simulator::Simulator(SimulatorOptions options, Script script, Scheduler& scheduler, transport::Transports& transports,
                     Log log)
    : options_(std::move(options)),
      scheduler_(scheduler),
      transports_(transports),
      log_(std::move(log)),
      bus_(scheduler, std::move(script.groups), options_.seed),
      server_(scheduler, transports, server_options(options_)),
      script_(scheduler, std::move(script.steps), [this](const Step& step) { take(step); }) {
  server_.set_weather(options_.weather);
}

Result<void> Simulator::open() {
  if (options_.tunnelling) {
    if (auto checked = check_users(options_.server); !checked) return checked;
    attach_server();
    if (auto started = server_.start(); !started) return started;
  }
  if (options_.routing) {
    if (auto opened = open_router(); !opened) return opened;
  }
  bus_.start();
  script_.begin();
  return {};
}

void Simulator::attach_server() {
  const auto line = bus_.attach([this](const Telegram& telegram) {
    if (const auto cemi = write_telegram(CemiCode::kDataIndication, telegram)) server_.send_to_clients(*cemi);
  });
  server_.on_frame = [this, line](const ClientFrame& frame) {
    auto telegram = read_telegram(frame.cemi);
    if (!telegram) return;
    telegram->source = IndividualAddress(frame.source);
    log_.info(text_of(*telegram));
    bus_.received(*telegram, line);
  };
}

Result<void> Simulator::open_router() {
  const auto line = bus_.attach([this](const Telegram& telegram) {
    if (router_) router_->send(telegram, scheduler_.now() + kRoutingWait, {});
  });
  LineCallbacks calls;
  calls.received = [this, line](const Telegram& telegram) {
    log_.info(text_of(telegram));
    bus_.received(telegram, line);
  };
  calls.failed = [this](const Error& why) {
    log_.error(why.text);
    reopen_router_ = scheduler_.after(kRetry, [this] { reopen_router(); });
  };
  router_ = std::make_unique<RoutingLine>(scheduler_, transports_, *options_.routing, std::move(calls));
  return router_->open();
}

void Simulator::reopen_router() {
  const auto opened = router_->open();
  if (opened) return;
  log_.error(opened.error().text);
  reopen_router_ = scheduler_.after(kRetry, [this] { reopen_router(); });
}

void Simulator::stop_server(Duration span) {
  server_.stop();
  restart_server_ = scheduler_.after(span, [this] { restart_server(); });
}

void Simulator::restart_server() {
  const auto started = server_.start();
  if (started) return;
  log_.error(started.error().text);
  restart_server_ = scheduler_.after(kRetry, [this] { restart_server(); });
}

void Simulator::take(const Step& step) {
  switch (step.kind) {
    case Step::Kind::kWrite: return bus_.write(step.group, step.value);
    case Step::Kind::kSet: return bus_.set(step.group, step.value);
    case Step::Kind::kRead: return bus_.read(step.group);
    case Step::Kind::kRamp: return bus_.ramp(step.group, step.from, step.to, step.span);
    case Step::Kind::kSilence: return bus_.silence(step.span);
    case Step::Kind::kDisconnect: return server_.disconnect_all();
    case Step::Kind::kStop: return stop_server(step.span);
    case Step::Kind::kRepeat: return;
  }
}

}  // namespace rubicon::knx_simulator
