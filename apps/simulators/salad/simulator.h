#pragma once

#include <map>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "apps/simulators/salad/script.h"
#include "apps/simulators/script.h"
#include "base/log.h"
#include "base/scheduler.h"
#include "networks/salad/salad_options.h"
#include "rubicon/result.hpp"
#include "transport/transports.h"

namespace rubicon::salad_simulator {

/// What a bad network, or a bad SALAD, does to a proxy.
enum class Misbehaviour : std::uint8_t {
  kGarbage,     ///< a datagram of each row of the bad-input table (salad.md, section 4), one after the other
  kLoss,        ///< one publication of five is not sent
  kDuplicates,  ///< one of five is sent twice
  kBursts,      ///< one of ten is sent fifty times
  kSilence,     ///< one of fifty is followed by five seconds of nothing
};

/// `garbage`, ..., or `all`; kInvalid names the words there are.
Result<std::set<Misbehaviour>> parse_misbehaviours(const std::vector<std::string>& words);

/// One datagram and more for each row of the bad-input table; `unknown` is an id that is not configured.
std::vector<std::string> bad_datagrams(unsigned unknown);

struct SimulatorOptions {
  std::uint16_t port = 9000;             ///< where proxies send to; 0 = any free one
  std::string bind = {};                 ///< numeric address it listens on; empty = all of the machine's
  std::string proxy_host = "localhost";  ///< where updates go
  std::uint16_t proxy_port = 9100;
  Duration period = std::chrono::milliseconds(500);
  bool eager = false;  ///< publishes from the start, without a start datagram and after a stop datagram
  /// 0..100: numbers that are no codes vary by up to this; on/off sensors flip for a period with this chance in
  /// percent.
  double noise = 0;
  std::set<Misbehaviour> misbehaviours;
  std::uint64_t seed = 1;
};

/// The address to listen on for a proxy on this host name: loopback if it is this machine, otherwise all addresses
/// (empty).
std::string listening_address(std::string_view proxy_host);

/// SALAD as a proxy sees it (salad.md, section 6, simulation variant): after a start datagram it publishes the stored
/// value of every device each period, at first 0; a command to a device with this actuator id stores its value.
class Simulator {
 public:
  using Devices = std::map<DeviceId, networks::salad::SaladDevice>;

  struct Counters {
    std::uint64_t publications = 0, datagrams = 0, starts = 0, stops = 0, commands = 0, unreadable = 0;
  };

  /// Scheduler, transports and log must outlive it.
  Simulator(SimulatorOptions options, Devices devices, std::vector<Step> script, const TypeCatalogue& types,
            Scheduler& scheduler, transport::Transports& transports, Log log);

  /// Opens its port and looks up the proxy's host, repeatedly until it is found. kBusy if the port is in use.
  Result<void> open();

  std::uint16_t port() const { return socket_ ? socket_->local().port : std::uint16_t{0}; }
  bool publishing() const { return publishing_ || options_.eager; }
  const Value& stored(DeviceId id) const { return stored_.at(id); }
  void store(DeviceId id, Value value);
  const Counters& counters() const { return counters_; }

 private:
  struct Motion {
    Step step;
    SteadyTime began, drawn;
  };

  void look_up();
  void received(ByteView bytes);
  void publish();
  void publish_once();
  void send(std::string_view text);
  void send_garbage();
  Value published(DeviceId id, const networks::salad::SaladDevice& device);
  void move_all();
  void take(const Step& step);
  bool by_chance(double share);

  SimulatorOptions options_;
  Devices devices_;
  simulation::ScriptRun<Step> script_;
  const TypeCatalogue& types_;
  Scheduler& scheduler_;
  transport::Transports& transports_;
  Log log_;
  std::unique_ptr<transport::UdpSocket> socket_;
  std::unique_ptr<transport::Lookup> lookup_;
  std::string proxy_;  ///< numeric address; empty = not looked up yet
  std::map<DeviceId, Value> stored_;
  std::map<DeviceId, Motion> motions_;
  bool publishing_ = false;
  SteadyTime silent_until_{};
  std::size_t next_bad_ = 0;
  std::vector<std::string> bad_;
  std::mt19937_64 rng_;
  Counters counters_;
  Timer period_timer_, lookup_timer_;
};

/// The program salad-simulator: reads its command line and runs until a signal ends it. Returns its exit code.
int run_program(int argc, char** argv);

}  // namespace rubicon::salad_simulator
