#include "client/ecology_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <random>

namespace rubicon::client {

namespace {

constexpr std::uint32_t kFirstId = 65536;
constexpr std::size_t kMaxTargets = 64;

std::vector<std::string> interfaces_of(const Options& options) {
  return options.interfaces.empty() ? std::vector<std::string>{"lo"} : options.interfaces;
}

/// Before there was engine host, a domain and a tag divided a host as spaces do now.
bool has_old_space(const Options& options) {
  return (options.domain != 0 || !options.tag.empty()) && !has_engine(options, Engine::kDds) &&
         has_engine(options, Engine::kHost);
}

Result<tuples::engines::HostSetup> host_setup(const Options& options) {
  auto around = tuples::host::Surroundings::of_process();
  if (!options.folder.empty()) around.given = options.folder;
  auto place = tuples::host::choose_place({}, around);
  if (!place) return fail(std::move(place.error()));
  auto space = options.space;
  if (space.empty())
    space =
        has_old_space(options) ? tuples::host::space_of(options.domain, options.tag) : tuples::host::choose_space({});
  if (auto good = tuples::host::check_space(space); !good)
    return fail(ErrorCode::kInvalid, "space " + good.error().text);
  return tuples::engines::HostSetup{std::move(*place), std::move(space), {options.lease}};
}

tuples::dds::DdsOptions dds_options(const Options& options) {
  tuples::dds::DdsOptions dds;
  dds.domain = options.domain;
  dds.interfaces = interfaces_of(options);
  dds.peers = options.peers;
  dds.tag = options.tag;
  dds.lease = options.lease;
  dds.transport = options.tcp ? tuples::dds::DdsTransport::kTcp : tuples::dds::DdsTransport::kUdp;
  dds.port = options.port;
  dds.trust_lan = options.trust_lan;
  return dds;
}

tuples::peis::PeisOptions peis_options(const Options& options) {
  tuples::peis::PeisOptions peis;
  peis.network = options.peis.network;
  peis.listen = options.peis.listen;
  for (const auto& url : options.peis.connect) peis.connect.push_back(tuples::peis::connect_target(url).value_or(url));
  peis.multicast = options.peis.multicast;
  peis.interfaces = interfaces_of(options);
  peis.lease = options.lease;
  peis.trust_lan = options.trust_lan;
  return peis;
}

std::uint16_t port_of(const Broker& broker) {
  return broker.port != 0 ? broker.port : broker.tls ? 8883 : 1883;
}

tuples::mqtt::SpaceOptions space_options(const Broker& broker) {
  tuples::mqtt::SpaceOptions space;
  tuples::mqtt::SpaceBroker first;
  first.line.host = broker.host;
  first.line.port = port_of(broker);
  first.line.user = broker.user;
  first.line.password = broker.password;
  if (broker.tls)
    first.line.tls = transport::MqttTls{broker.ca_file, broker.certificate_file, broker.key_file, broker.server_name};
  if (!broker.user.empty()) first.user = broker.user;
  std::vector<base::HostPort> spare;
  for (const auto& one : broker.spare)
    spare.push_back(base::parse_host_port(one, port_of(broker)).value_or(base::HostPort{}));
  space.brokers = tuples::mqtt::with_spare(std::move(first), spare);
  space.space = broker.space;
  space.lease = broker.lease;
  space.trust_broker = broker.trust;
  space.watch_all = broker.all;
  return space;
}

Result<void> check_broker(const Broker& broker) {
  if (broker.host.empty()) return fail(ErrorCode::kInvalid, "engine mqtt needs a broker");
  for (const auto& one : broker.spare) {
    if (!base::parse_host_port(one, 1883))
      return fail(ErrorCode::kInvalid, fmt::format("spare broker '{}': expected HOST[:PORT]", one));
  }
  if (broker.certificate_file.empty() != broker.key_file.empty())
    return fail(ErrorCode::kInvalid, "broker: a certificate needs a key, and a key a certificate");
  if (auto good = tuples::mqtt::check_options(space_options(broker)); !good)
    return fail(ErrorCode::kInvalid, "broker: " + good.error().text);
  return {};
}

Result<void> check_dds(const Options& options) {
  if (options.domain > tuples::dds::kMaxDomain)
    return fail(ErrorCode::kInvalid,
                fmt::format("domain {}: expected 0 to {}", options.domain, tuples::dds::kMaxDomain));
  if (options.tcp && options.peers.empty() && options.port == 0)
    return fail(ErrorCode::kInvalid, "tcp needs peers (host:port) or a port: it discovers no components by itself");
  return {};
}

Result<void> check_peis(const Options& options) {
  const auto& peis = options.peis;
  if (peis.network.empty() || peis.network.size() > tuples::peis::kMaxNameLength)
    return fail(ErrorCode::kInvalid, fmt::format("PEIS network '{}': expected 1 to {} characters", peis.network,
                                                 tuples::peis::kMaxNameLength));
  if (peis.connect.size() > kMaxTargets)
    return fail(ErrorCode::kInvalid, fmt::format("PEIS: {} components to connect to, expected at most {}",
                                                 peis.connect.size(), kMaxTargets));
  for (const auto& url : peis.connect) {
    const auto target = tuples::peis::connect_target(url);
    if (!target) return fail(ErrorCode::kInvalid, fmt::format("PEIS: connect to '{}': {}", url, target.error().text));
    if (tuples::peis::leaves_loopback(interfaces_of(options), *target))
      return fail(
          ErrorCode::kInvalid,
          fmt::format("PEIS: connect to '{}': lo reaches no other host, expected another interface too, such as eth0",
                      url));
  }
  return {};
}

}  // namespace

Result<std::shared_ptr<trust::site::LiveRealm>> open_realm(const Options& options, Scheduler& scheduler,
                                                           base::LogSink& log) {
  if (!has_engine(options, Engine::kMqtt)) return std::shared_ptr<trust::site::LiveRealm>();
  return trust::site::LiveRealm::open(options.broker.ca_file, options.broker.user, scheduler, base::Log(log, "mqtt"));
}

OwnerId component_id(const Options& options) {
  if (options.id != model::kNoOwner) return options.id;
  std::random_device source;
  return OwnerId(std::uniform_int_distribution<std::uint32_t>(kFirstId, tuples::peis::kMaxId)(source));
}

Result<void> check(const Options& options) {
  const auto id = number(options.id);
  const bool peis = has_engine(options, Engine::kPeis), dds = has_engine(options, Engine::kDds);
  const bool host = has_engine(options, Engine::kHost);
  if (id != 0 && id < kFirstId)
    return fail(ErrorCode::kInvalid,
                fmt::format("component id {}: expected a number above 65535, the others are islands", id));
  if (id > tuples::peis::kMaxId && peis)
    return fail(ErrorCode::kInvalid, fmt::format("component id {}: PEIS has ids up to {}", id, tuples::peis::kMaxId));
  if (const auto good = dds ? check_dds(options) : Result<void>(); !good) return good;
  if (const auto good = has_engine(options, Engine::kMqtt) ? check_broker(options.broker) : Result<void>(); !good)
    return good;
  if (const auto good = peis ? check_peis(options) : Result<void>(); !good) return good;
  if (const auto setup = host ? host_setup(options) : tuples::engines::HostSetup(); !setup) return fail(setup.error());
  return {};
}

bool has_engine(const Options& options, Engine engine) {
  const auto& named = options.engines;
  if (!named.empty()) return std::find(named.begin(), named.end(), engine) != named.end();
  return engine == Engine::kHost || (engine == Engine::kDds && !options.interfaces.empty()) ||
         (engine == Engine::kMqtt && !options.broker.host.empty());
}

std::string old_space_warning(const Options& options) {
  if (!options.space.empty() || !has_old_space(options)) return {};
  return fmt::format(
      "domain and tag are of engine dds: without interfaces they are the space {} of this host, expected "
      "space: {}",
      tuples::host::space_of(options.domain, options.tag), tuples::host::space_of(options.domain, options.tag));
}

Result<tuples::engines::EngineOptions> engine_options(const Options& options) {
  tuples::engines::EngineOptions engines;
  if (has_engine(options, Engine::kHost)) {
    auto setup = host_setup(options);
    if (!setup) return fail(std::move(setup.error()));
    engines.host = std::move(*setup);
  }
  if (has_engine(options, Engine::kDds)) engines.dds = dds_options(options);
  if (has_engine(options, Engine::kMqtt)) engines.mqtt = space_options(options.broker);
  if (has_engine(options, Engine::kPeis)) engines.peis = peis_options(options);
  return engines;
}

}  // namespace rubicon::client
