#include "apps/simulators/salad/simulator.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "rubicon/key.hpp"

namespace rubicon::salad_simulator {

namespace {

constexpr std::array<std::pair<std::string_view, Misbehaviour>, 5> kNames{{{"garbage", Misbehaviour::kGarbage},
                                                                           {"loss", Misbehaviour::kLoss},
                                                                           {"duplicates", Misbehaviour::kDuplicates},
                                                                           {"bursts", Misbehaviour::kBursts},
                                                                           {"silence", Misbehaviour::kSilence}}};

}  // namespace

Result<std::set<Misbehaviour>> parse_misbehaviours(const std::vector<std::string>& words) {
  std::set<Misbehaviour> found;
  for (const auto& word : words) {
    bool known = word == "all";
    for (const auto& [name, kind] : kNames) {
      if (word != name && word != "all") continue;
      found.insert(kind);
      known = true;
    }
    if (!known)
      return fail(ErrorCode::kInvalid,
                  fmt::format("{}: expected garbage, loss, duplicates, bursts, silence or all", model::quoted(word)));
  }
  return found;
}

std::vector<std::string> bad_datagrams(unsigned unknown) {
  std::vector<std::string> all{"garbage", "", std::string("\0\x01\xff\xfe#SALADST#", 13), "#SALADST#", "#SALADST##"};
  for (const auto* value : {"abc", "", "1,5", "NaN", "Infinity", "-Infinity", "1e400", "0x1", "1f", "1d"})
    all.push_back(fmt::format("#SALADST#1;{}#END#", value));
  for (const auto* id : {"x", "", "-1", "0", "65536", "99999999999999999999", "1.5"})
    all.push_back(fmt::format("#SALADST#{};1#END#", id));
  all.push_back(fmt::format("#SALADST#{};7#END#", unknown));
  all.insert(all.end(), {"#SALADST#1#END#", "#SALADST#1;1;1#END#", "#SALADST#;#END#", "#SALADST#:::#END#"});
  all.push_back("#SALADST#1;" + std::string(60000, '9'));
  return all;
}

namespace {

using namespace std::chrono_literals;
using networks::salad::Item;
using networks::salad::Request;
using networks::salad::SaladDevice;

/// Datagrams of this size pass every network whole, and every buffer of a proxy.
constexpr std::size_t kMaxDatagramLength = 1400;
constexpr Duration kLookupPause = 1s;
constexpr Duration kSilence = 5s;
constexpr int kBurst = 50;

/// Whole where it is whole, else with three digits behind the point.
Value number(double value) {
  const double rounded = std::round(value * 1000) / 1000;
  if (std::floor(rounded) == rounded && std::abs(rounded) < 1e15) return static_cast<std::int64_t>(rounded);
  return rounded;
}

double as_double(const Value& value) {
  if (const auto* whole = std::get_if<std::int64_t>(&value)) return static_cast<double>(*whole);
  const auto* real = std::get_if<double>(&value);
  return real ? *real : 0;
}

unsigned unused_id(const Simulator::Devices& devices) {
  DeviceId id = 1;
  while (id < 65535 && devices.contains(id)) ++id;
  return id;
}

}  // namespace

std::string listening_address(std::string_view proxy_host) {
  if (proxy_host == "::1") return "::1";
  const bool numeric = proxy_host.find_first_not_of("0123456789.") == proxy_host.npos;
  const bool here = proxy_host == "localhost" || (numeric && proxy_host.starts_with("127."));
  return here ? "127.0.0.1" : "";
}

Simulator::Simulator(SimulatorOptions options, Devices devices, std::vector<Step> script, const TypeCatalogue& types,
                     Scheduler& scheduler, transport::Transports& transports, Log log)
    : options_(std::move(options)),
      devices_(std::move(devices)),
      script_(scheduler, std::move(script), [this](const Step& step) { take(step); }),
      types_(types),
      scheduler_(scheduler),
      transports_(transports),
      log_(std::move(log)),
      bad_(bad_datagrams(unused_id(devices_))),
      rng_(options_.seed) {
  for (const auto& [id, device] : devices_) stored_[id] = std::int64_t{0};
}

Result<void> Simulator::open() {
  transport::UdpCallbacks calls;
  calls.received = [this](const transport::Endpoint&, ByteView bytes) { received(bytes); };
  calls.undelivered = [](const Error&) {};  // a proxy that is not there yet
  calls.failed = [this](const Error& why) { log_.error(why.text); };
  auto socket = transports_.open_udp({{options_.bind, options_.port}, 2048}, std::move(calls));
  if (!socket) return fail(socket.error());
  socket_ = std::move(*socket);
  look_up();
  script_.begin();
  period_timer_ = scheduler_.after(options_.period, [this] { publish(); });
  return {};
}

void Simulator::look_up() {
  lookup_ = transports_.look_up(options_.proxy_host, [this](Result<std::vector<std::string>> found) {
    lookup_.reset();
    if (found) {
      proxy_ = found->front();
      return;
    }
    log_.warning(found.error().text);
    lookup_timer_ = scheduler_.after(kLookupPause, [this] { look_up(); });
  });
}

void Simulator::store(DeviceId id, Value value) {
  const auto stored = stored_.find(id);
  if (stored != stored_.end()) stored->second = std::move(value);
}

void Simulator::received(ByteView bytes) {
  const auto request = networks::salad::read_request(bytes);
  if (!request) {
    ++counters_.unreadable;
    return;
  }
  if (request->kind != Request::Kind::kActuate) {
    const bool start = request->kind == Request::Kind::kStart;
    ++(start ? counters_.starts : counters_.stops);
    if (std::exchange(publishing_, start) != start) log_.info(start ? "updates start" : "updates stop");
    return;
  }
  ++counters_.commands;
  log_.info(fmt::format("{} := {}", request->actuator, request->value));
  for (const auto& [id, device] : devices_) {
    if (device.actuator == request->actuator) stored_[id] = request->value;
  }
}

bool Simulator::by_chance(double share) {
  return std::uniform_real_distribution<>(0, 1)(rng_) < share;
}

void Simulator::publish() {
  period_timer_ = scheduler_.after(options_.period, [this] { publish(); });
  move_all();
  if (!publishing() || proxy_.empty() || scheduler_.now() < silent_until_) return;
  const auto does = [this](Misbehaviour kind, double share) {
    return options_.misbehaviours.contains(kind) && by_chance(share);
  };
  if (does(Misbehaviour::kGarbage, 1)) send_garbage();
  if (does(Misbehaviour::kLoss, 0.2)) return;
  ++counters_.publications;
  const int times = does(Misbehaviour::kBursts, 0.1) ? kBurst : does(Misbehaviour::kDuplicates, 0.2) ? 2 : 1;
  for (int i = 0; i < times; ++i) publish_once();
  if (does(Misbehaviour::kSilence, 0.02)) silent_until_ = scheduler_.now() + kSilence;
}

void Simulator::publish_once() {
  std::vector<Item> items;
  std::size_t length = 0;
  for (const auto& [id, device] : devices_) {
    items.push_back({id, published(id, device)});
    length += 7 + model::to_text(items.back().value).size();
    if (length < kMaxDatagramLength) continue;
    send(networks::salad::write_datagram(std::exchange(items, {})));
    length = 0;
  }
  if (!items.empty()) send(networks::salad::write_datagram(items));
}

void Simulator::send(std::string_view text) {
  ++counters_.datagrams;
  const auto sent = socket_->send({proxy_, options_.proxy_port}, base::as_bytes(text));
  if (!sent && sent.error().code != ErrorCode::kBusy) log_.debug(sent.error().text);
}

void Simulator::send_garbage() {
  send(bad_[next_bad_++ % bad_.size()]);
}

Value Simulator::published(DeviceId id, const SaladDevice& device) {
  const Value& stored = stored_.at(id);
  const auto* type = types_.find(device.type_id);
  if (options_.noise <= 0 || type == nullptr || !device.actuator.empty() || !device.sensor) return stored;
  const double now = as_double(stored);
  if (type->data == model::DataType::kBoolean)
    return by_chance(options_.noise / 100) ? Value(std::int64_t{now == 0 ? 1 : 0}) : stored;
  if (type->data != model::DataType::kReal) return stored;
  const double moved = now + std::uniform_real_distribution<>(-options_.noise, options_.noise)(rng_);
  return number(std::clamp(moved, type->minimum, type->maximum));
}

/// Ramps and random values, as far as they have come.
void Simulator::move_all() {
  const auto now = scheduler_.now();
  for (auto& [id, motion] : motions_) {
    const auto& step = motion.step;
    if (step.kind == Step::Kind::kRamp) {
      const double share =
          std::min(1.0, static_cast<double>((now - motion.began).count()) / static_cast<double>(step.span.count()));
      stored_[id] = number(step.from + (step.to - step.from) * share);
    } else if (now >= motion.drawn) {
      stored_[id] = number(std::round(std::uniform_real_distribution<>(step.from - 0.499, step.to + 0.499)(rng_)));
      motion.drawn = now + step.span;
    }
  }
  std::erase_if(motions_, [now](const auto& motion) {
    const auto& [id, one] = motion;
    return one.step.kind == Step::Kind::kRamp && now >= one.began + one.step.span;
  });
}

void Simulator::take(const Step& step) {
  switch (step.kind) {
    case Step::Kind::kSet:
      motions_.erase(step.id);
      store(step.id, number(step.to));
      return;
    case Step::Kind::kRamp:
    case Step::Kind::kRandom:
      if (stored_.contains(step.id)) motions_[step.id] = {step, scheduler_.now(), scheduler_.now()};
      return;
    case Step::Kind::kHold: motions_.erase(step.id); return;
    case Step::Kind::kSilence: silent_until_ = scheduler_.now() + step.span; return;
    case Step::Kind::kGarbage:
      if (publishing() && !proxy_.empty()) {
        for (std::size_t i = 0; i < bad_.size(); ++i) send_garbage();
      }
      return;
    case Step::Kind::kRepeat: return;
  }
}

}  // namespace rubicon::salad_simulator
