#include <algorithm>
#include <set>

#include "motes/framing.h"
#include "motes/mote_records.h"
#include "motes/rig.h"

namespace rubicon::bench::motes {

namespace {

using namespace std::chrono_literals;
using motes_simulator::Event;

constexpr int kMotes = 10;
constexpr int kClients = 5;
constexpr std::uint16_t kSharePort = 9002;
constexpr auto kStep = 10ms;
constexpr auto kTimeout = 10min;

/// A command to the lamp of a mote, never twice with the same value.
Bytes packet(std::uint16_t island, int value) {
  const auto record = rubicon::motes::encode_record(rubicon::motes::ActuateCommand{1, value});
  const auto mote = static_cast<std::uint16_t>(2 + value % kMotes);
  return rubicon::motes::packet_of(rubicon::motes::NetMessage{
      island, mote, island, rubicon::motes::kBaseMote, 0, static_cast<std::uint16_t>(value), 0,
      rubicon::motes::kTransportConnectionless, rubicon::motes::kApplicationMockup, record});
}

/// Motes that obey, and what they executed.
struct Lamps {
  Lamps() : rig(1, kMotes, obedient(), [this](const Event& event) { hear(event); }) {}

  static motes_simulator::MoteOptions obedient() {
    motes_simulator::MoteOptions like;
    like.obey = true;
    return like;
  }
  void hear(const Event& event) {
    if (event.what != "actuator") return;
    lit.insert(*event.value);
    ++executed;
    last = rig.time.now();
  }
  /// Runs until nothing was executed for a while.
  void settle(int commands) {
    const auto began = rig.time.now();
    for (last = began; executed < static_cast<std::uint64_t>(commands) && rig.time.now() < last + 20s &&
                       rig.time.now() < began + kTimeout;)
      rig.time.run_for(kStep);
  }

  std::set<std::int64_t> lit;
  std::uint64_t executed = 0;
  SteadyTime last{};
  VirtualRig rig;
};

/// A program at the serial forwarder that sends all its packets at once.
class Client {
 public:
  Client(transport::Transports& transports, int first, int count) {
    transport::TcpOptions options;
    options.remote = {"127.0.0.1", kSharePort};
    transport::TcpCallbacks calls;
    calls.connected = [this, first, count] {
      must(stream_->send(rubicon::motes::kForwarderHello));
      for (int i = 0; i < count; ++i) must(stream_->send(rubicon::motes::forwarder_packet(packet(kIsland, first + i))));
    };
    calls.received = [](ByteView) {};
    calls.failed = [this](const Error&) { lost_ = true; };
    stream_ = must(transports.open_tcp(options, std::move(calls)));
  }
  bool lost() const { return lost_; }

 private:
  bool lost_ = false;
  std::unique_ptr<transport::TcpStream> stream_;
};

int counter(island::Island& island, const std::string& name) {
  const auto tuple = island.space().get(kIslandOwner, "proxy.wsn-1.property." + name + ".value");
  return tuple ? std::stoi(std::string(tuple->value)) : 0;
}

Json through_the_island(int commands) {
  Lamps lamps;
  auto& rig = lamps.rig;
  const auto island = start_island(island_of(ports_of(1), "silence: never, island-check: never, share: 9002"), rig.time,
                                   rig.transports, rig.ecology);
  rig.time.run_for(20s);
  const auto began = rig.time.now();
  std::vector<std::unique_ptr<Client>> clients;
  const int each = commands / kClients;
  for (int i = 0; i < kClients; ++i) clients.push_back(std::make_unique<Client>(rig.transports, i * each, each));
  const auto taken = [&] { return counter(*island, "share-packets-from-clients"); };
  rig.time.run_for(2s);  // they have sent everything, and the counter is reported once a second
  const auto at_once = taken();
  lamps.settle(each * kClients);
  const auto last = lamps.last;
  rig.time.run_for(5s);
  const auto lost = std::count_if(clients.begin(), clients.end(), [](const auto& one) { return one->lost(); });
  return {{"commands", each * kClients},
          {"executed", lamps.lit.size()},
          {"executed_twice", lamps.executed - lamps.lit.size()},
          {"seconds", rounded(std::chrono::duration<double>(last - began).count(), 1)},
          {"taken_after_2_s", at_once},
          {"taken", taken()},
          {"lost_clients", lost}};
}

/// The sink's line without an island: all at once, or (`paced`) each after the acknowledgement of the previous one.
class BareLine {
 public:
  BareLine(transport::Transports& transports, int commands, bool paced) : commands_(commands) {
    transport::TcpOptions options;
    options.remote = {"127.0.0.1", kFirstPort};
    transport::TcpCallbacks calls;
    calls.connected = [] {};
    calls.received = [this, paced](ByteView bytes) {
      while (const auto frame = reader_.next(bytes)) {
        if (paced && began_ && frame->protocol == rubicon::motes::kHdlcAck) next();
      }
    };
    calls.failed = [](const Error&) {};
    stream_ = must(transports.open_tcp(options, std::move(calls)));
  }
  void begin(bool paced) {
    began_ = true;
    do {
      next();
    } while (!paced && sent_ < commands_);
  }

 private:
  void next() {
    if (sent_ >= commands_) return;
    const auto sequence = static_cast<std::uint8_t>(sent_);
    must(stream_->send(rubicon::motes::hdlc_acked_packet(sequence, packet(11, sent_++))));
  }

  int commands_, sent_ = 0;
  bool began_ = false;
  rubicon::motes::HdlcReader reader_;
  std::unique_ptr<transport::TcpStream> stream_;
};

Json straight(int commands, bool paced) {
  Lamps lamps;
  BareLine line(lamps.rig.transports, commands, paced);
  lamps.rig.time.run_for(20s);
  const auto began = lamps.rig.time.now();
  line.begin(paced);
  lamps.settle(commands);
  return {{"executed", lamps.lit.size()},
          {"seconds", rounded(std::chrono::duration<double>(lamps.last - began).count(), 1)}};
}

}  // namespace

void measure_paced_clients(const Plan& plan, Json& out) {
  auto ours = through_the_island(plan.commands);
  ours["floor_one_by_one"] = straight(plan.commands, true);
  ours["peer_unpaced"] = straight(plan.commands, false);
  const double floor = ours["floor_one_by_one"]["seconds"].get<double>();
  ours["ratio"] = floor > 0 ? rounded(ours["seconds"].get<double>() / floor, 3) : 0;
  out["paced_clients"] = ours;
}

}  // namespace rubicon::bench::motes
