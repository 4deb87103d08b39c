#include <random>
#include <set>
#include <stdexcept>

#include "knx/measurements.h"
#include "networks/knx/line/tunnel_line.h"
#include "support/knxd.h"
#include "transport/asio_scheduler.h"
#include "transport/local_transports.h"

namespace rubicon::bench::knx {

namespace {

using namespace std::chrono_literals;
using namespace networks::knx::line;
using namespace networks::knx::wire;

constexpr std::uint16_t kPort = 3671;
/// So many telegrams wait in the queue while one is under way.
constexpr int kWaiting = 64;

Telegram write_of(int value) {
  Telegram telegram;
  telegram.destination = GroupAddress(0x0a07);
  telegram.payload.bytes = {static_cast<std::uint8_t>(value >> 8), static_cast<std::uint8_t>(value)};
  return telegram;
}

/// A tunnel to a port of this host, opened again whenever it is lost.
class Client {
 public:
  Client(transport::Loop& loop, std::uint16_t port) : loop_(loop), lines_(loop) {
    TunnelOptions options;
    options.host = "127.0.0.1";
    options.port = port;
    options.nat = TunnelOptions::Nat::kOn;
    options.limits.rate = 0;
    LineCallbacks calls;
    calls.changed = [this](const LineState& state) {
      if (state.phase == LineState::Phase::kUp && up) up();
    };
    calls.failed = [this](const Error&) { again_ = loop_.scheduler().after(100ms, [this] { open(); }); };
    calls.received = [](const Telegram&) {};
    calls.frame = [](ByteView, bool) {};
    line_ = std::make_unique<TunnelLine>(options, loop_.scheduler(), lines_, std::move(calls));
  }
  void open() {
    if (!line_->open()) throw std::runtime_error("the tunnel cannot be opened");
  }
  Line& line() { return *line_; }
  std::function<void()> up;

 private:
  transport::Loop& loop_;
  transport::LocalTransports lines_;
  Timer again_;
  std::unique_ptr<TunnelLine> line_;
};

double our_telegrams(int telegrams) {
  transport::Loop loop;
  Client client(loop, kPort);
  int asked = 0, done = 0;
  Clock::time_point start;
  double rate = 0;
  const std::function<void()> more = [&] {
    for (; asked < telegrams && asked - done < kWaiting; ++asked) {
      client.line().send(write_of(asked), loop.scheduler().now() + 60s, [&](SendOutcome outcome, std::string_view) {
        if (outcome != SendOutcome::kSent) throw std::runtime_error("a telegram was not confirmed");
        if (++done == telegrams) {
          rate = telegrams / seconds_since(start);
          loop.stop();
        } else {
          more();
        }
      });
    }
  };
  client.up = [&] {
    start = Clock::now();
    more();
  };
  client.open();
  loop.run();
  return rate;
}

/// Passes datagrams on both ways and loses some of them.
class LossyRelay {
 public:
  LossyRelay(transport::Loop& loop, double loss, unsigned seed) : lines_(loop), loss_(loss), random_(seed) {
    front_ = open([this](const transport::Endpoint& from, ByteView bytes) {
      client_ = from;
      pass(*back_, {"127.0.0.1", kPort}, bytes);
    });
    back_ = open([this](const transport::Endpoint&, ByteView bytes) { pass(*front_, client_, bytes); });
  }
  std::uint16_t port() const { return front_->local().port; }

 private:
  std::unique_ptr<transport::UdpSocket> open(std::function<void(const transport::Endpoint&, ByteView)> received) {
    transport::UdpCallbacks calls{std::move(received), [](const Error&) {}, [](const Error&) {}};
    auto opened = lines_.open_udp({{"127.0.0.1", 0}}, std::move(calls));
    if (!opened) throw std::runtime_error(opened.error().text);
    return std::move(*opened);
  }
  void pass(transport::UdpSocket& through, const transport::Endpoint& to, ByteView bytes) {
    if (std::uniform_real_distribution<double>(0, 1)(random_) >= loss_) std::ignore = through.send(to, bytes);
  }

  transport::LocalTransports lines_;
  double loss_;
  std::mt19937 random_;
  transport::Endpoint client_;
  std::unique_ptr<transport::UdpSocket> front_, back_;
};

/// `Write from 1.1.205 to 1/2/7: 0C 33 ` -> the values in the order they came.
std::vector<int> values_in(const std::string& heard) {
  std::vector<int> values;
  for (std::size_t at = heard.find("1/2/7: "); at != heard.npos; at = heard.find("1/2/7: ", at + 1)) {
    values.push_back(std::stoi(heard.substr(at + 7, 2), nullptr, 16) * 256 +
                     std::stoi(heard.substr(at + 10, 2), nullptr, 16));
  }
  return values;
}

void wait_until_it_listens(const support::Knxd& knxd, const support::KnxdListener& listener) {
  for (int i = 0; i < 100 && listener.heard().find("7/7/7") == std::string::npos; ++i) {
    knxd.tool("groupswrite", {"7/7/7", "1"});
    ::usleep(50'000);
  }
}

Json one_seed(const support::Knxd& knxd, int writes, unsigned seed) {
  const support::KnxdListener listener(knxd);
  wait_until_it_listens(knxd, listener);
  transport::Loop loop;
  LossyRelay relay(loop, 0.03, seed);
  Client client(loop, relay.port());
  std::set<int> failed;
  int done = 0, unconfirmed = 0;
  const auto start = Clock::now();
  for (int i = 0; i < writes; ++i) {
    client.line().send(write_of(i), loop.scheduler().now() + 60s, [&, i](SendOutcome outcome, std::string_view) {
      if (outcome == SendOutcome::kUnconfirmed) {
        ++unconfirmed;
      } else if (outcome != SendOutcome::kSent) {
        failed.insert(i);
      }
      if (++done == writes) loop.stop();
    });
  }
  client.open();
  loop.run();
  const auto took = seconds_since(start);
  ::usleep(300'000);  // what knxd still passes to its listener
  const auto values = values_in(listener.heard());
  const std::set<int> delivered(values.begin(), values.end());
  int false_failures = 0;
  for (const int value : failed) false_failures += delivered.contains(value) ? 1 : 0;
  return {{"seed", seed},
          {"delivered", delivered.size()},
          {"unconfirmed", unconfirmed},
          {"failed", failed.size()},
          {"false_failures", false_failures},
          {"twice", values.size() - delivered.size()},
          {"seconds", took}};
}

/// knxd in a network of its own; says why not in `out`.
template <class Measure>
void with_knxd(Json& out, const char* what, Measure measure) {
  const support::KnxNetwork network;
  if (!network.entered()) {
    out[std::string(what) + "_skipped"] = network.reason();
    return;
  }
  const support::Knxd knxd(false);
  bool ready = false;
  for (int i = 0; i < 400 && !(ready = knxd.ready()); ++i) ::usleep(25'000);
  if (!ready) {
    out[std::string(what) + "_skipped"] = "knxd does not come up";
    return;
  }
  measure(knxd);
}

}  // namespace

void measure_telegrams(const Plan& plan, Json& out) {
  with_knxd(out, "telegrams", [&](const support::Knxd&) {
    std::vector<double> ours, bare, ratios;
    for (int round = 0; round < plan.rounds; ++round) {
      bare.push_back(floor_telegrams(plan.telegrams, kPort));
      ours.push_back(our_telegrams(plan.telegrams));
      ratios.push_back(ours.back() / bare.back());
    }
    out["telegrams_per_second"] = median(ours);
    out["floor_telegrams_per_second"] = median(bare);
    out["ratio"] = median(ratios);
    out["rounds"] = {{"telegrams_per_second", ours}, {"floor_telegrams_per_second", bare}};
  });
}

void measure_loss(const Plan& plan, Json& out) {
  with_knxd(out, "loss", [&](const support::Knxd& knxd) {
    out["loss"] = Json::array();
    for (unsigned seed = 1; seed <= 5; ++seed) out["loss"].push_back(one_seed(knxd, plan.writes, seed));
  });
}

}  // namespace rubicon::bench::knx
