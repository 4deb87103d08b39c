#include <time.h>

#include <stdexcept>

#include "apps/simulators/knx/server.h"
#include "knx/measurements.h"
#include "networks/knx/line/tunnel_line.h"
#include "networks/knx/secure/passwords.h"
#include "networks/knx/secure/session_channel.h"
#include "support/private_network.h"
#include "transport/asio_scheduler.h"
#include "transport/local_transports.h"

namespace rubicon::bench::knx {

namespace {

using namespace std::chrono_literals;
using namespace networks::knx;
using namespace networks::knx::line;

constexpr int kInFlight = 64;

secure::Key key_from(std::uint8_t first) {
  secure::Key key;
  for (auto& byte : key.span()) byte = first++;
  return key;
}

/// A tunnel over TCP to a responder of our own on the same loop: both ends are in the figures.
double tcp_telegrams(int telegrams, bool secured) {
  transport::Loop loop;
  transport::LocalTransports lines(loop);
  knx_simulator::ServerOptions server_options;
  server_options.at = {"127.0.0.1", 0};
  if (secured) server_options.secure = knx_simulator::SecureOptions{key_from(1), {{2, key_from(2), 0}}};
  knx_simulator::Server server(loop.scheduler(), lines, server_options);
  if (const auto started = server.start(); !started) throw std::runtime_error(started.error().text);
  TunnelOptions options;
  options.host = "127.0.0.1";
  options.port = server.local().port;
  options.via = TunnelOptions::Via::kTcp;
  options.limits.rate = 0;
  if (secured) options.secure = secure::SessionKeys{2, {key_from(2), {}}, secure::PasswordKey{key_from(1), {}}};
  int asked = 0, done = 0;
  Clock::time_point start;
  double rate = 0;
  std::function<void()> more;
  LineCallbacks calls;
  calls.changed = [&](const LineState& state) {
    if (state.phase != LineState::Phase::kUp) return;
    start = Clock::now();
    more();
  };
  calls.failed = [](const Error& error) { throw std::runtime_error(error.text); };
  TunnelLine line(options, loop.scheduler(), lines, calls);
  more = [&] {
    for (; asked < telegrams && asked - done < kInFlight; ++asked) {
      wire::Telegram telegram;
      telegram.destination = wire::GroupAddress(0x0a07);
      telegram.payload.bytes = {static_cast<std::uint8_t>(asked >> 8), static_cast<std::uint8_t>(asked)};
      line.send(telegram, loop.scheduler().now() + 60s, [&](SendOutcome outcome, std::string_view) {
        if (outcome != SendOutcome::kSent) throw std::runtime_error("a telegram was not confirmed");
        if (++done < telegrams) return more();
        rate = telegrams / seconds_since(start);
        loop.stop();
      });
    }
  };
  if (!line.open()) throw std::runtime_error("the tunnel cannot be opened");
  loop.run();
  return rate;
}

double processor_ms() {
  timespec now{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) / 1e6;
}

/// Processor time of the client's half of a handshake: key pair, check of the server, session key, authentication.
double handshake_ms(int handshakes) {
  transport::Loop loop;
  const secure::SessionKeys keys{2, {key_from(2), {}}, secure::PasswordKey{key_from(1), {}}};
  secure::SessionCounters counters;
  secure::Ccm ccm;
  const auto server = secure::KeyPair::make(secure::system_random()).value();
  double spent = 0;
  for (int i = 0; i < handshakes; ++i) {
    Bytes request;
    secure::Session::Callbacks calls;
    calls.transmit = [&](ByteView frame) { request.assign(frame.begin(), frame.end()); };
    calls.ended = [](const secure::Session::End& end) { throw std::runtime_error(end.why); };
    auto begin = processor_ms();
    secure::Session session(loop.scheduler(), keys, {}, counters, std::move(calls));
    session.start();
    spent += processor_ms() - begin;
    const auto client = secure::read_session_request(wire::read_frame(request).value())->public_key;
    const auto mac = secure::response_mac(ccm, key_from(1), 1, client, server.public_key()).value();
    const auto response = write(secure::SessionResponse{1, server.public_key(), mac});
    begin = processor_ms();
    session.receive(response);
    spent += processor_ms() - begin;
  }
  return spent / handshakes;
}

double password_ms() {
  std::vector<double> times;
  for (int i = 0; i < 9; ++i) {
    const auto begin = Clock::now();
    if (!secure::user_key(secure::Secret::of_text("tunnel two"))) throw std::runtime_error("PBKDF2");
    times.push_back(milliseconds(Clock::now() - begin));
  }
  return median(times);
}

}  // namespace

void measure_secure(const Plan& plan, Json& out) {
  auto& figures = out["secure"];
  figures["handshake_cpu_ms"] = rounded(handshake_ms(200), 3);
  figures["password_ms"] = rounded(password_ms(), 2);
  figures["floor_telegrams_per_second"] = rounded(floor_wrappers(10 * plan.telegrams), 0);
  const support::PrivateNetwork network;
  if (!network.entered()) {
    figures["skipped"] = network.reason();
    return;
  }
  std::vector<double> plain, secured, ratios;
  for (int round = 0; round < plan.rounds; ++round) {
    plain.push_back(tcp_telegrams(plan.telegrams, false));
    secured.push_back(tcp_telegrams(plan.telegrams, true));
    ratios.push_back(secured.back() / plain.back());
  }
  figures["tcp_telegrams_per_second"] = rounded(median(plain), 0);
  figures["telegrams_per_second"] = rounded(median(secured), 0);
  figures["ratio"] = rounded(median(ratios), 2);
}

}  // namespace rubicon::bench::knx
