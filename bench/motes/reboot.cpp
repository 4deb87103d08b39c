#include <fmt/format.h>

#include <set>

#include "motes/framing.h"
#include "motes/mote_records.h"
#include "motes/rig.h"
#include "transport/asio_scheduler.h"
#include "transport/local_transports.h"

namespace rubicon::bench::motes {

namespace {

using namespace std::chrono_literals;
using motes_simulator::Event;

constexpr int kRebootMotes = 200;
/// Seven requests in three seconds (wsn.md 9.2), and what follows.
constexpr auto kBetweenReboots = 4s;
constexpr auto kRebootPatience = 20min;

motes_simulator::Step reboot_all() {
  return {};  // all motes together
}

/// Joins that a sink sent, until they are heard.
class Joins {
 public:
  void hear(const Event& event) {
    if (event.what == "listed") {
      latest_ = event.mote;
      waiting_[event.mote] = Clock::now();
      ++emitted_;
    } else if (event.what == "serial-full") {  // logged in the same call: the sink had no room for what it emits
      if (latest_ != 0 && waiting_.erase(latest_) > 0) --emitted_;
    } else if (event.what == "joined") {
      return;  // between a join and its packet
    }
    if (event.what != "listed") latest_ = 0;
  }
  void heard(std::uint16_t mote) {
    const auto found = waiting_.find(mote);
    if (found == waiting_.end()) return;
    took.push_back(milliseconds(Clock::now() - found->second));
    waiting_.erase(found);
  }
  std::uint64_t emitted() const { return emitted_; }
  std::vector<double> took;  ///< milliseconds

 private:
  std::uint16_t latest_ = 0;
  std::uint64_t emitted_ = 0;
  std::map<std::uint16_t, Clock::time_point> waiting_;
};

/// Sinks of one process, in real time on ports of the system.
class RealWorld {
 public:
  RealWorld(transport::Loop& loop, transport::Transports& transports, int sinks)
      : loop_(loop), world_(options(sinks), loop.scheduler(), {}, [this](const Event& event) { joins.hear(event); }) {
    for (std::uint16_t sink = 1; sink <= sinks; ++sink) {
      must(world_.open(sink,
                       motes_simulator::on_tcp(transports, {"127.0.0.1", 0},
                                               [this](const transport::Endpoint& at) { ports.push_back(at.port); })));
    }
  }
  void run(int reboots) {
    int done = 0;
    Timer next;
    const std::function<void()> again = [&] {
      if (done++ == reboots) return loop_.stop();
      if (done > 1) world_.execute(reboot_all());
      next = loop_.scheduler().after(kBetweenReboots, again);
    };
    again();
    loop_.run();
  }

  Joins joins;
  std::vector<std::uint16_t> ports;

 private:
  static motes_simulator::WorldOptions options(int sinks) {
    auto options = world_of(sinks, kRebootMotes / sinks);
    options.boot_spacing = {};
    return options;
  }
  transport::Loop& loop_;
  motes_simulator::World world_;
};

Json summary(const Joins& joins) {
  return {{"emitted", joins.emitted()},
          {"lost", joins.emitted() - joins.took.size()},
          {"p50_ms", rounded(median(joins.took), 2)},
          {"p99_ms", rounded(percentile(joins.took, 0.99), 2)},
          {"max_ms", rounded(percentile(joins.took, 1), 2)}};
}

Json listed(const Plan& plan, int sinks) {
  transport::Loop loop;
  transport::LocalTransports transports(loop);
  RealWorld world(loop, transports, sinks);
  tuples::MemoryEcology ecology(loop.scheduler());
  const auto island =
      start_island(island_of(world.ports, "silence: 60s, share: no"), loop.scheduler(), transports, ecology);
  std::uint64_t unlisted = 0;
  const auto listener = island->gateway().subscribe(MessageKind::kJoin, [&](const Message& message) {
    const auto mote = static_cast<std::uint16_t>(std::stoi(message.source.device));
    const auto sink = static_cast<std::uint16_t>((mote - 2) / (kRebootMotes / sinks) + 1);
    if (reachable(*island, sink, mote)) return world.joins.heard(mote);
    ++unlisted;
  });
  world.run(plan.reboots);
  auto figures = summary(world.joins);
  figures["unlisted"] = unlisted;
  return figures;
}

/// A program that only reads the lines and looks for joins.
class BareReader {
 public:
  BareReader(transport::Transports& transports, std::uint16_t port, Joins& joins) : joins_(joins) {
    transport::TcpOptions options;
    options.remote = {"127.0.0.1", port};
    transport::TcpCallbacks calls;
    calls.connected = [] {};
    calls.received = [this](ByteView bytes) {
      while (const auto frame = reader_.next(bytes)) look(frame->packet);
    };
    calls.failed = [](const Error&) {};
    stream_ = must(transports.open_tcp(options, std::move(calls)));
  }

 private:
  void look(ByteView bytes) {
    const auto packet = rubicon::motes::decode_packet(bytes);
    const auto net = packet ? rubicon::motes::decode_net(packet->payload) : Result<rubicon::motes::NetMessage>();
    if (!net) return;
    const auto record = rubicon::motes::decode_record(*net);
    if (record && std::holds_alternative<rubicon::motes::Joined>(*record)) joins_.heard(net->source_mote);
  }
  Joins& joins_;
  rubicon::motes::HdlcReader reader_;
  std::unique_ptr<transport::TcpStream> stream_;
};

Json floor_of(const Plan& plan, int sinks) {
  transport::Loop loop;
  transport::LocalTransports transports(loop);
  RealWorld world(loop, transports, sinks);
  std::vector<std::unique_ptr<BareReader>> readers;
  for (const auto port : world.ports) readers.push_back(std::make_unique<BareReader>(transports, port, world.joins));
  world.run(plan.reboots);
  return summary(world.joins);
}

/// Virtual time: all motes are known and rebooted together; which are heard again, and when.
Json found_again(int sinks) {
  std::set<std::uint16_t> believe, listed;
  const auto note = [&](const Event& event) {
    if (event.what == "joined") believe.insert(event.mote);
    if (event.what == "listed") listed.insert(event.mote);
  };
  VirtualRig rig(sinks, kRebootMotes / sinks, {}, note);
  const auto island =
      start_island(island_of(ports_of(sinks), "silence: 60s, share: no"), rig.time, rig.transports, rig.ecology);
  rig.time.run_for(2min);
  std::map<std::uint16_t, double> found;
  auto from = rig.time.now();
  std::vector<Handle> listeners;
  for (const auto kind : {MessageKind::kJoin, MessageKind::kKeepAlive, MessageKind::kUpdates}) {
    listeners.push_back(island->gateway().subscribe(kind, [&](const Message& message) {
      found.try_emplace(static_cast<std::uint16_t>(std::stoi(message.source.device)),
                        std::chrono::duration<double>(rig.time.now() - from).count());
    }));
  }
  believe.clear();
  listed.clear();
  from = rig.time.now();
  rig.world->execute(reboot_all());
  rig.time.run_ready();
  found.clear();
  rig.time.run_for(kRebootPatience);
  std::vector<double> seconds;
  std::uint64_t in_time = 0, later = 0, unheard = 0;
  for (const auto mote : believe) {
    if (listed.contains(mote)) continue;
    ++unheard;
    if (!found.contains(mote)) continue;
    seconds.push_back(found[mote]);
    (found[mote] <= 60 ? in_time : later) += 1;
  }
  return {{"motes", kRebootMotes},
          {"believe_they_joined", believe.size()},
          {"joins_emitted", listed.size()},
          {"joined_unheard", unheard},
          {"found_within_silence", in_time},
          {"found_later", later},
          {"found_share", rounded(unheard > 0 ? static_cast<double>(in_time) / static_cast<double>(unheard) : 1, 4)},
          {"found_s", {{"median", rounded(median(seconds), 1)}, {"max", rounded(percentile(seconds, 1), 1)}}}};
}

}  // namespace

void measure_reboot(const Plan& plan, Json& out) {
  Json figures;
  for (const int sinks : {10, 1}) {
    auto& one = figures[fmt::format("{}x{}", sinks, kRebootMotes / sinks)];
    one["listed"] = listed(plan, sinks);
    one["floor_listed"] = floor_of(plan, sinks);
    one["found_again"] = found_again(sinks);
  }
  out["reboot"] = figures;
}

}  // namespace rubicon::bench::motes
