#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <random>
#include <stdexcept>

#include "motes/framing.h"
#include "motes/line_sink.h"
#include "motes/mote_records.h"
#include "motes/rig.h"
#include "transport/asio_scheduler.h"
#include "transport/local_transports.h"

namespace rubicon::bench::motes {

namespace {

using namespace std::chrono_literals;

/// The motes get their sampling commands in this time: some 70 ms each, one at a time.
constexpr auto kSettle = 4s;

/// From one command to the next: nothing of the previous one is under way, and no beat with the frames.
Clock::duration pause(std::mt19937& rng) {
  return std::chrono::milliseconds(130 + rng() % 60);
}

/// Of the nth command; not repeated within a measurement.
int mote_of(std::size_t n) {
  return LineSink::kFirstMote + static_cast<int>(n % LineSink::kMotes);
}
int value_of(std::size_t n) {
  return static_cast<int>(n / LineSink::kMotes % 255 + 1);
}

struct Round {
  std::uint64_t frames = 0, readings = 0, events = 0;
  std::vector<std::int64_t> asked;  ///< steady clock, ns
  LineSeen seen;

  /// In microseconds, of those that arrived.
  std::vector<double> took() const {
    std::vector<double> all;
    for (std::size_t i = 0; i < asked.size(); ++i) {
      const auto found = seen.commands.find({mote_of(i), value_of(i)});
      if (found != seen.commands.end()) all.push_back(static_cast<double>(found->second - asked[i]) / 1000);
    }
    return all;
  }
};

/// A distant client that receives all light and switches lamps.
class Commander {
 public:
  Commander(tuples::Ecology& ecology, Scheduler& scheduler)
      : scheduler_(scheduler), component_(ecology, scheduler, 70001) {
    light_ = component_->subscribe({kIslandOwner, "proxy.wsn-1.*.sensor.light-1.value"}, {},
                                   [this](const tuples::Event& event) { events_ += !event.tuple.value.empty(); });
  }
  void begin(Clock::time_point until) {
    until_ = until;
    next();
  }
  std::uint64_t events() const { return events_; }
  std::vector<std::int64_t> asked;

 private:
  void next() {
    if (Clock::now() > until_) return;
    const auto key = fmt::format("proxy.wsn-1.{}.actuator.led-1.command", mote_of(asked.size()));
    const auto value = std::to_string(value_of(asked.size()));
    asked.push_back(Clock::now().time_since_epoch().count());
    component_->set_remote(kIslandOwner, key, value, {}, [](const tuples::Reply& reply) {
      if (reply.verdict != Verdict::kApplied) throw std::runtime_error("a command was refused: " + reply.text);
    });
    again_ = scheduler_.after(pause(rng_), [this] { next(); });
  }

  Scheduler& scheduler_;
  Component component_;
  Handle light_;
  std::uint64_t events_ = 0;
  Clock::time_point until_;
  std::mt19937 rng_{3};
  Timer again_;
};

std::uint64_t light_readings(const Message& message, TypeId light) {
  const auto& readings = std::get<model::Updates>(message.body).readings;
  return static_cast<std::uint64_t>(
      std::count_if(readings.begin(), readings.end(), [&](const auto& one) { return one.point.type == light; }));
}

Round with_island(std::chrono::seconds span) {
  LineSink sink(span);
  Round round;
  {
    transport::Loop loop;
    transport::LocalTransports transports(loop);
    tuples::MemoryEcology ecology(loop.scheduler());
    const auto island = start_island(island_of({sink.port()}, "silence: 60s, share: no, actuators: assumed"),
                                     loop.scheduler(), transports, ecology);
    const auto light = TypeCatalogue().find("light")->id;
    const auto listener = island->gateway().subscribe(
        MessageKind::kUpdates, [&](const Message& message) { round.readings += light_readings(message, light); });
    Commander commander(ecology, loop.scheduler());
    const auto start = loop.scheduler().after(kSettle, [&] { commander.begin(Clock::now() + span - kSettle - 500ms); });
    const auto end = loop.scheduler().after(span + 1s, [&loop] { loop.stop(); });
    loop.run();
    round.events = commander.events();
    round.asked = commander.asked;
  }
  round.seen = sink.seen();
  round.frames = round.seen.frames;
  return round;
}

/// The same line at the other end of a bare socket: frames are read without decoding, commands written unchanged.
class BareComputer {
 public:
  explicit BareComputer(std::uint16_t port) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(port);
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const int yes = 1;
    if (::connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0 ||
        ::setsockopt(socket_, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes) != 0)
      throw std::runtime_error("connect");
    write(rubicon::motes::packet_of(rubicon::motes::AmType::kConfig,
                                    rubicon::motes::encode_config({rubicon::motes::kSetIslandId, kIsland})));
  }
  ~BareComputer() { ::close(socket_); }
  BareComputer(const BareComputer&) = delete;
  BareComputer& operator=(const BareComputer&) = delete;

  void command(std::size_t number) {
    const auto record = rubicon::motes::encode_record(rubicon::motes::ActuateCommand{1, value_of(number)});
    write(rubicon::motes::packet_of(rubicon::motes::NetMessage{
        kIsland, static_cast<std::uint16_t>(mote_of(number)), kIsland, rubicon::motes::kBaseMote, 1,
        static_cast<std::uint16_t>(number), 0, rubicon::motes::kTransportConnectionless,
        rubicon::motes::kApplicationMockup, record}));
  }
  void read_until(Clock::time_point until) {
    for (auto left = until - Clock::now(); left > 0ns; left = until - Clock::now()) {
      pollfd wanted{socket_, POLLIN, 0};
      const timespec wait{left / 1s, static_cast<long>((left % 1s).count())};
      std::array<char, 4096> buffer;
      if (::ppoll(&wanted, 1, &wait, nullptr) > 0 && ::recv(socket_, buffer.data(), buffer.size(), 0) <= 0) return;
    }
  }

 private:
  void write(ByteView packet) {
    const auto bytes = rubicon::motes::hdlc_acked_packet(++sequence_, packet);
    if (::send(socket_, bytes.data(), bytes.size(), 0) < 0) throw std::runtime_error("send");
  }
  int socket_;
  std::uint8_t sequence_ = 0;
};

Round bare(std::chrono::seconds span) {
  LineSink sink(span);
  Round round;
  {
    BareComputer computer(sink.port());
    std::mt19937 rng(3);
    const auto end = Clock::now() + span - 500ms;
    computer.read_until(Clock::now() + 500ms);
    for (std::size_t number = 0; Clock::now() < end; ++number) {
      round.asked.push_back(Clock::now().time_since_epoch().count());
      computer.command(number);
      computer.read_until(Clock::now() + pause(rng));
    }
    computer.read_until(Clock::now() + 1s);
  }
  round.seen = sink.seen();
  return round;
}

}  // namespace

void measure_line_rate(const Plan& plan, Json& out) {
  std::vector<double> p50, p99, floor50, floor99;
  std::uint64_t frames = 0, lost = 0, unseen = 0, commands = 0, unsent = 0;
  double worst = 0;
  for (int round = 0; round < plan.rounds; ++round) {
    const auto floor = bare(std::max<std::chrono::seconds>(plan.line / 2, 3s)).took();
    floor50.push_back(percentile(floor, 0.5));
    floor99.push_back(percentile(floor, 0.99));
    const auto ours = with_island(plan.line);
    const auto took = ours.took();
    p50.push_back(percentile(took, 0.5));
    p99.push_back(percentile(took, 0.99));
    worst = std::max(worst, percentile(took, 1));
    frames += ours.frames;
    lost += ours.frames - ours.readings;
    unseen += ours.frames - std::min(ours.frames, ours.events);
    commands += took.size();
    unsent += ours.asked.size() - took.size();
  }
  const auto per_second = static_cast<double>(frames) / static_cast<double>(plan.rounds * plan.line.count());
  out["line_rate"] = {
      {"readings", frames},
      {"readings_per_second", rounded(per_second, 1)},
      {"lost", lost},
      {"merged_for_the_subscriber", unseen},
      {"commands", commands},
      {"commands_lost", unsent},
      {"command_us", {{"p50", rounded(median(p50), 0)}, {"p99", rounded(median(p99), 0)}, {"max", rounded(worst, 0)}}},
      {"floor_us", {{"p50", rounded(median(floor50), 0)}, {"p99", rounded(median(floor99), 0)}}},
      {"ratio",
       {{"p50", rounded(median(p50) / median(floor50), 2)}, {"p99", rounded(median(p99) / median(floor99), 2)}}}};
}

}  // namespace rubicon::bench::motes
