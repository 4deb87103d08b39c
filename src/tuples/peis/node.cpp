#include "tuples/peis/node.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/text.h"
#include "tuples/peis/forgeries.h"
#include "tuples/peis/node_links.h"
#include "tuples/peis/node_presence.h"
#include "tuples/peis/node_routing.h"
#include "tuples/peis/packages.h"
#include "tuples/peis/places.h"

namespace rubicon::tuples::peis {

namespace {

constexpr std::size_t kMaxConfigured = 64;

Result<void> check(const NodeOptions& options) {
  const auto wrong = [](const std::string& what) { return fail(ErrorCode::kInvalid, "PEIS: " + what); };
  const auto fits = [](const std::string& text) { return !text.empty() && text.size() <= kMaxNameLength; };
  const auto id = number(options.id);
  if (id == 0 || id > kMaxId) return wrong(fmt::format("id {}: expected 1 to {}", id, kMaxId));
  if (options.magic == 0 || options.magic > kMaxId) return wrong(fmt::format("magic {}: out of range", options.magic));
  if (!fits(options.network)) return wrong("network: expected 1 to 63 bytes");
  if (!fits(options.host_name) || !fits(options.full_name)) return wrong("names: expected 1 to 63 bytes");
  if (options.interfaces.empty()) return wrong("no interface");
  if (options.connect.size() > kMaxConfigured) return wrong("more than 64 hosts to connect to");
  return {};
}

Result<std::vector<base::HostPort>> parse(const std::vector<std::string>& connect) {
  std::vector<base::HostPort> hosts;
  for (const auto& text : connect) {
    const auto host = base::parse_host_port(text, kFirstListenPort);
    if (!host || host->host.empty())
      return fail(ErrorCode::kInvalid, fmt::format("PEIS: connect to {}: expected HOST or HOST:PORT", text));
    hosts.push_back(*host);
  }
  return hosts;
}

}  // namespace

/// Wires the parts of a node.
struct Node::Impl {
  Impl(NodeOptions options, std::vector<base::HostPort> connect, Scheduler& scheduler,
       transport::Transports& transports, Log log, NodeCallbacks node_calls);
  ~Impl();
  Result<void> open();
  NodeLinks::Callbacks link_calls();
  Hosts::Callbacks host_calls();
  Dialer::Callbacks dialer_calls();

  NodeContext context;
  NodeCallbacks calls;
  Hosts hosts;
  Deliveries deliveries;
  NodeLinks links;
  NodeRouting routing;
  Dialer dialer;
  Places places;
  Forgeries forgeries;
  NodePresence presence;
  Packages packages;
  base::OncePerTurn pumping;
};

Node::Node(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Node::~Node() = default;

Result<std::unique_ptr<Node>> Node::open(NodeOptions options, Scheduler& scheduler, transport::Transports& transports,
                                         Log log, NodeCallbacks calls) {
  if (auto sound = check(options); !sound) return fail(sound.error());
  options.interfaces.resize(std::min(options.interfaces.size(), kMaxAddresses));
  auto connect = parse(options.connect);
  if (!connect) return fail(connect.error());
  auto impl = std::make_unique<Impl>(std::move(options), std::move(*connect), scheduler, transports, std::move(log),
                                     std::move(calls));
  if (auto opened = impl->open(); !opened) return fail(opened.error());
  return std::unique_ptr<Node>(new Node(std::move(impl)));
}

Result<void> Node::send(OwnerId to, Port port, ByteView body, Done done) {
  auto& impl = *impl_;
  if (!impl.hosts.is_up(to))
    return fail(ErrorCode::kNotFound, fmt::format("{}: component {} is not here", to_string(port), number(to)));
  const auto* route = impl.routing.routes().find(to);
  if (route && !route->direct) impl.dialer.prefer_direct(to);
  return impl.deliveries.send(to, port, body, std::move(done));
}

void Node::rename(std::string full_name) {
  impl_->context.options.full_name = std::move(full_name);
}

Result<void> Node::broadcast(Port port, ByteView body) {
  if (body.size() > kMaxBody || static_cast<std::uint16_t>(port) > kLastPort)
    return fail(ErrorCode::kOutOfRange,
                fmt::format("{}: {} bytes to all: too long, or no port of PEIS", to_string(port), body.size()));
  Bytes package;
  append_package(package, impl_->deliveries.next_header(Routing::kBroadcast, port, kEveryone), body);
  impl_->links.flood(package, std::nullopt);
  return {};
}

std::vector<Identity> Node::hosts() const {
  return impl_->hosts.up();
}

const Identity* Node::host(OwnerId id) const {
  return impl_->hosts.find(id);
}

bool Node::is_here(OwnerId id) const {
  return impl_->links.is_here(id);
}

std::size_t Node::unacknowledged(OwnerId to) const {
  return impl_->deliveries.unacknowledged(to);
}

transport::Endpoint Node::local() const {
  return impl_->links.local();
}

std::vector<LinkState> Node::links() const {
  std::vector<LinkState> states;
  for (const auto& [id, link] : impl_->links.all()) {
    const auto& connection = *link.connection;
    states.push_back({link.peer, connection.remote(), connection.bytes_in(), connection.bytes_out(),
                      connection.unacknowledged(), link.ours});
  }
  return states;
}

std::vector<RouteState> Node::routes() const {
  std::vector<RouteState> states;
  for (const auto& [to, route] : impl_->routing.routes().all()) states.push_back({to, route.via, route.metric});
  return states;
}

const std::vector<Trouble>& Node::troubles() const {
  return impl_->context.troubles.all();
}

const NodeCounters& Node::counters() const {
  return impl_->context.counters;
}

Node::Impl::Impl(NodeOptions options, std::vector<base::HostPort> connect, Scheduler& scheduler,
                 transport::Transports& transports, Log log, NodeCallbacks node_calls)
    : context{std::move(options), scheduler, transports, base::LimitedLog(std::move(log), scheduler)},
      calls(std::move(node_calls)),
      hosts(scheduler, context.counters, host_calls()),
      deliveries(scheduler, context.options.id, context.options.magic * 2654435761u, context.counters,
                 {[this](OwnerId to, std::span<std::uint8_t> package, bool urgent) {
                    return routing.emit(to, package, urgent);
                  },
                  [this](OwnerId to) { calls.ready(to); }}),
      links(context, hosts, deliveries, link_calls()),
      routing(context, links, hosts, deliveries),
      dialer(scheduler, transports,
             {context.options.id, context.options.host_name, std::move(connect), context.options.magic,
              is_loopback_only(context.options)},
             dialer_calls()),
      places(context, hosts, routing.routes(), links, dialer,
             [this](const Package& package) { packages.take_message(package); }),
      forgeries(context, hosts, routing.routes()),
      presence(context, calls, hosts, links, routing, deliveries, dialer, places, forgeries),
      packages(context, calls, hosts, links, routing, deliveries, places, forgeries, presence),
      pumping(scheduler, [this] { deliveries.pump(); }) {}

Hosts::Callbacks Node::Impl::host_calls() {
  Hosts::Callbacks on;
  on.event = [this](HostEvent event, const Identity& host) { presence.happened(event, host); };
  on.greet = [this](OwnerId host) { presence.welcome(host); };
  on.gone = [this](OwnerId host) {
    deliveries.close(host);
    packages.forget(host);
    presence.gone(host);
  };
  on.query = [this](OwnerId host) {
    routing.send(host, Port::kQueryHost, write(QueryHost{context.options.id, kAnyId}));
  };
  on.returned = [this](const Identity& host) { presence.returned(host); };
  return on;
}

NodeLinks::Callbacks Node::Impl::link_calls() {
  return {[this](NodeLink& link) { presence.greet(link); },
          [this](NodeLink& link, const Package& package) { packages.received(link, package); },
          [this] { pumping.request(); },
          [this](const NodeLink& link, SteadyTime heard, bool broken) { presence.unlinked(link, heard, broken); }};
}

Dialer::Callbacks Node::Impl::dialer_calls() {
  Dialer::Callbacks on;
  on.is_linked = [this](OwnerId host) { return links.is_linked(host); };
  on.is_routable = [this](OwnerId host) { return routing.routes().find(host) != nullptr; };
  on.record = [this](OwnerId host) { return hosts.record(host); };
  on.claim = [this](OwnerId host) { return hosts.claim(host); };
  on.dial = [this](const Target& target, const transport::Endpoint& to, std::uint32_t flags) {
    return links.dial(target, to, flags);
  };
  on.unresolved = [this](const Target& target, const Error& error) { links.unreachable(target, error); };
  on.refused = [this](OwnerId host) {
    ++context.counters.untried_hosts;
    context.log.warning("untried",
                        fmt::format("component {}: not tried, there are too many hosts to connect to", number(host)));
  };
  return on;
}

/// Says goodbye; the system still sends what it took.
Node::Impl::~Impl() {
  Bytes package;
  const auto dead = write(DeadHost{context.options.id, DeathReason::kLost});
  append_package(package, deliveries.next_header(Routing::kBroadcast, Port::kDeadHost, kEveryone), dead);
  for (const auto& [id, link] : links.all()) {
    if (link.is_route()) link.connection->send(package, true);
  }
  links.end();
}

Result<void> Node::Impl::open() {
  if (auto listening = links.listen(); !listening) return listening;
  presence.begin();
  routing.begin();
  return {};
}

}  // namespace rubicon::tuples::peis
