#include "web/roles.h"

#include <fmt/format.h>
#include <unistd.h>

#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/streambuf.hpp>
#include <filesystem>
#include <iostream>
#include <stdexcept>

#include "base/text.h"
#include "frame/process_figures.h"
#include "frame/running_island.h"
#include "rubicon/summary.hpp"
#include "transport/asio_scheduler.h"
#include "transport/local_transports.h"
#include "web/generated_points.h"
#include "web/paced_updates.h"
#include "web/web_service.h"

namespace rubicon::bench::web {

namespace {

using namespace std::chrono_literals;

constexpr std::uint32_t kDomain = 196, kServer = 70002;

/// Follows the lines of standard input.
class Orders {
 public:
  Orders(transport::Loop& loop, PacedUpdates& updates)
      : loop_(loop), updates_(updates), input_(loop.context(), ::dup(STDIN_FILENO)) {
    read();
  }

 private:
  void read() {
    boost::asio::async_read_until(input_, pending_, '\n', [this](const auto& error, std::size_t) {
      if (error) return loop_.stop();
      std::string line;
      std::istream stream(&pending_);
      std::getline(stream, line);
      follow(line);
      read();
    });
  }
  void follow(const std::string& line) {
    constexpr std::string_view kRate = "rate ";
    if (line.starts_with(kRate)) updates_.set_rate(base::parse_number<int>(line.substr(kRate.size())).value_or(0));
    fmt::print("{}\n", updates_.made());
    std::fflush(stdout);
  }

  transport::Loop& loop_;
  PacedUpdates& updates_;
  boost::asio::posix::stream_descriptor input_;
  boost::asio::streambuf pending_;
};

void obey(transport::Loop& loop, PacedUpdates& updates, int port) {
  const Orders orders(loop, updates);
  fmt::print("ready {}\n", port);
  std::fflush(stdout);
  loop.run();
}

/// The tuples of an island whose devices have joined and report.
class GeneratedIsland {
 public:
  GeneratedIsland(TupleSpace& space, WallTime now, int devices) : space_(space), now_(seconds(now)) {
    model::Summary summary{"generated", "bench", "rubicon-bench-web", "proxy", now, {{"hall", devices}}};
    must(space.describe(model::to_json(summary)));
    set_json("proxy.island", R"({{"id":{},"name":"generated"}})", kIsland);
    set_json("proxy.hall.status", R"({{"line":"up","since":{:.3f},"reason":""}})", now_);
    for (int device = 0; device < devices; ++device) add_device(device);
  }
  std::size_t points() const { return values_.size(); }
  void update(std::uint64_t number, WallTime now) {
    tuples::SetOptions options;
    options.user_time = now;
    must(space_.set(values_[number % values_.size()], value_of(number), options));
  }

 private:
  static double seconds(WallTime time) { return std::chrono::duration<double>(time.time_since_epoch()).count(); }
  template <class... Parts>
  void set_json(const std::string& key, fmt::format_string<Parts...> form, Parts&&... parts) {
    tuples::SetOptions options;
    options.media_type = "application/json";
    must(space_.set(key, fmt::format(form, std::forward<Parts>(parts)...), options));
  }
  void add_device(int device) {
    const auto key = device_key(device);
    set_json(key + ".description",
             R"({{"name":"device {}","area":"room {}","model":"EM1000","type":"mote","address":"{}","network":"hall",)"
             R"("capabilities":["temperature","humidity","light","carbonDioxide","battery"]}})",
             device, device % 200, device);
    set_json(key + ".status", R"({{"status":"reachable","since":{:.3f},"reason":""}})", now_);
    for (int i = 0; i < kPointsPerDevice; ++i) add_point(point_key(values_.size()));
  }
  void add_point(const std::string& key) {
    set_json(
        key + ".description",
        R"({{"type":"{}","quantity":"","unit":"1","data_type":"number","access":"read","report":"state","instance":"1"}})",
        key.substr(key.rfind('.') + 1));
    set_json(key + ".status", R"({{"quality":"good","since":{0:.3f},"heard":{0:.3f},"changed":{0:.3f},"reason":""}})",
             now_);
    values_.push_back(must(space_.set(key + ".value", "0.0")));
  }

  TupleSpace& space_;
  double now_;
  std::vector<tuples::TupleRef> values_;
};

int play_island(int devices, std::uint16_t port) {
  transport::Loop loop;
  transport::LocalTransports transports(loop);
  auto& scheduler = loop.scheduler();
  const auto ecology = join_on_loopback(kDomain, scheduler);
  Component owner(*ecology, scheduler, kIsland);
  GeneratedIsland island(*owner, scheduler.wall_now(), devices);
  Component server(*ecology, scheduler, kServer);
  config::WebSetup setup;
  setup.listen.port = port;
  const auto service = must(rubicon::web::WebService::open({loop.context(), scheduler, *server, transports, nowhere()},
                                                           setup, "", "generated"));
  PacedUpdates updates(scheduler, [&](std::uint64_t update) { island.update(update, scheduler.wall_now()); });
  const auto address = service->address();
  obey(loop, updates, base::parse_number<int>(address.substr(address.rfind(':') + 1)).value_or(0));
  return 0;
}

int play_publisher(int devices, std::uint16_t port) {
  transport::Loop loop;
  transport::LocalTransports transports(loop);
  transport::MqttOptions options;
  options.host = "127.0.0.1";
  options.port = port;
  transport::MqttCallbacks calls;
  calls.connected = [&loop](const transport::MqttConnack&) { loop.stop(); };
  calls.received = [](const transport::MqttMessage&) {};
  calls.refused = [](std::string_view, const Error&) {};
  calls.failed = [](const Error& why) { throw std::runtime_error(why.text); };
  const auto line = must(transports.open_mqtt(options, std::move(calls)));
  loop.run();
  std::vector<std::string> topics;
  for (std::size_t point = 0; point < static_cast<std::size_t>(devices) * kPointsPerDevice; ++point) {
    topics.push_back(point_key(point));
    std::replace(topics.back().begin(), topics.back().end(), '.', '/');
  }
  PacedUpdates updates(loop.scheduler(), [&](std::uint64_t update) {
    transport::MqttPublication publication;
    publication.topic = topics[update % topics.size()];
    const std::chrono::duration<double> now = loop.scheduler().wall_now().time_since_epoch();
    publication.payload = fmt::format("{} {:.3f}", value_of(update), now.count());
    must(line->publish(std::move(publication)));
  });
  obey(loop, updates, port);
  return 0;
}

}  // namespace

std::optional<int> play_role(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  if (arguments.size() != 3 || !arguments[0].starts_with("--")) return std::nullopt;
  const auto devices = base::parse_number<int>(arguments[1]);
  const auto port = base::parse_number<std::uint16_t>(arguments[2]);
  if (!devices || !port) return std::nullopt;
  if (arguments[0] == "--island") return play_island(*devices, *port);
  if (arguments[0] == "--publisher") return play_publisher(*devices, *port);
  return std::nullopt;
}

RoleProcess::RoleProcess(const std::string& role, int devices, int port)
    : process_({std::filesystem::read_symlink("/proc/self/exe").string(), "--" + role, std::to_string(devices),
                std::to_string(port)}) {
  const auto line = process_.line_with("ready ");
  if (!line) throw std::runtime_error("the role " + role + " does not start: " + process_.errors());
  port_ = base::parse_number<int>(line->substr(line->rfind(' ') + 1)).value_or(0);
}

std::uint64_t RoleProcess::set_rate(int rate) {
  return base::parse_number<std::uint64_t>(ask(fmt::format("rate {}", rate))).value_or(0);
}

std::uint64_t RoleProcess::made() {
  return base::parse_number<std::uint64_t>(ask("made")).value_or(0);
}

double RoleProcess::processor() const {
  return processor_seconds(process_.pid());
}

double RoleProcess::resident_mb() const {
  return static_cast<double>(process_.resident_kilobytes()) * 1.024 / 1000;
}

std::string RoleProcess::ask(const std::string& line) {
  process_.write(line + "\n");
  const auto answer = process_.line();
  if (!answer) throw std::runtime_error("a role ended: " + process_.errors());
  return *answer;
}

}  // namespace rubicon::bench::web
