#include "tuples/peis/node.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/host_port.h"
#include "tuples/peis/node_impl.h"

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

bool is_loopback_only(const NodeOptions& options) {
  return std::all_of(options.interfaces.begin(), options.interfaces.end(),
                     [](const auto& interface) { return interface.is_loopback; });
}

}  // namespace

Node::Node(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Node::~Node() = default;

Result<std::unique_ptr<Node>> Node::open(NodeOptions options, Scheduler& scheduler, transport::Transports& transports,
                                         Log log, NodeCalls calls) {
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
  const auto* route = impl.routes.find(to);
  if (route && !route->direct) impl.dialer.prefer_direct(to);
  return impl.deliveries.send(to, port, body, std::move(done));
}

void Node::rename(std::string full_name) {
  impl_->options.full_name = std::move(full_name);
}

Result<void> Node::broadcast(Port port, ByteView body) {
  if (body.size() > kMaxBody || static_cast<std::uint16_t>(port) > kLastPort)
    return fail(ErrorCode::kOutOfRange,
                fmt::format("{}: {} bytes to all: too long, or no port of PEIS", to_string(port), body.size()));
  Bytes package;
  append_package(package, impl_->header_for(Routing::kBroadcast, port, kEveryone), body);
  impl_->flood(package, std::nullopt);
  return {};
}

std::vector<Identity> Node::hosts() const {
  return impl_->hosts.up();
}

const Identity* Node::host(OwnerId id) const {
  return impl_->hosts.find(id);
}

bool Node::is_here(OwnerId id) const {
  return impl_->is_here(id);
}

std::size_t Node::unacknowledged(OwnerId to) const {
  return impl_->deliveries.unacknowledged(to);
}

transport::Endpoint Node::local() const {
  return impl_->local;
}

std::vector<LinkState> Node::links() const {
  std::vector<LinkState> states;
  for (const auto& [id, link] : impl_->links) {
    const auto& connection = *link.connection;
    states.push_back({link.peer, connection.remote(), connection.bytes_in(), connection.bytes_out(),
                      connection.unacknowledged(), link.ours});
  }
  return states;
}

std::vector<RouteState> Node::routes() const {
  std::vector<RouteState> states;
  for (const auto& [to, route] : impl_->routes.all()) states.push_back({to, route.via, route.metric});
  return states;
}

const std::vector<Trouble>& Node::troubles() const {
  return impl_->troubles.all();
}

const Counters& Node::counters() const {
  return impl_->counters;
}

Node::Impl::Impl(NodeOptions o, std::vector<base::HostPort> connect, Scheduler& s, transport::Transports& t, Log l,
                 NodeCalls c)
    : options(std::move(o)),
      scheduler(s),
      transports(t),
      log(std::move(l), s),
      calls(std::move(c)),
      hosts(s, counters,
            {[this](HostEvent event, const Identity& host) { happened(event, host); },
             [this](OwnerId host) { welcome(host); },
             [this](OwnerId host) {
               deliveries.close(host);
               fragments.forget(host);
               forgetful.erase(host);
             },
             [this](OwnerId host) {
               send_direct(host, Port::kQueryHost, write(QueryHost{options.id, kAnyId}));
             },
             [this](const Identity& host) { returned(host); }}),
      routes(options.id, counters, [this](OwnerId host, std::uint32_t magic) { return hosts.is_over(host, magic); }),
      deliveries(
          s, options.id, options.magic * 2654435761u, counters,
          {[this](OwnerId to, std::span<std::uint8_t> package, bool urgent) { return emit(to, package, urgent); },
           [this](OwnerId to) { calls.ready(to); }}),
      fragments(s),
      dialer(s, t, {options.id, options.host_name, std::move(connect), options.magic, is_loopback_only(options)},
             {[this](OwnerId host) { return is_linked(host); },
              [this](OwnerId host) { return routes.find(host) != nullptr; },
              [this](OwnerId host) { return hosts.record(host); }, [this](OwnerId host) { return hosts.claim(host); },
              [this](const Target& target, const transport::Endpoint& to, std::uint32_t flags) {
                return dial(target, to, flags);
              },
              [this](const Target& target, const Error& error) { unreachable(target, error); },
              [this](OwnerId host) {
                ++counters.untried_hosts;
                log.warning("untried",
                            fmt::format("component {}: not connected to, too many hosts to connect to", number(host)));
              }}),
      id_check(s, t, {options.id, 0, options.network}, [this](const Identity& other) { id_taken(other); }),
      place_due(s, [this] { release(); }),
      updates(s, kUpdatePause, [this] { update(); }),
      cleaning(s, [this] { over.clear(); }),
      pumping(s, [this] { deliveries.pump(); }) {}

/// Says goodbye; the system still sends what it took.
Node::Impl::~Impl() {
  lifetime.end();
  Bytes package;
  const auto dead = write(DeadHost{options.id, DeathReason::kLost});
  append_package(package, header_for(Routing::kBroadcast, Port::kDeadHost, kEveryone), dead);
  for (auto& [id, link] : links) {
    if (link.is_route()) link.connection->send(package, true);
    link.connection->close();
  }
}

Result<void> Node::Impl::open() {
  auto listening = listen(options.first_port);
  for (int i = 1; options.first_port != 0 && i < kPortsToTry && !listening; ++i) {
    if (listening.error().code != ErrorCode::kBusy || options.first_port + i > 0xffff) break;
    listening = listen(static_cast<std::uint16_t>(options.first_port + i));
  }
  if (!listening) return listening;
  if (options.multicast) {
    announcer = std::make_unique<Announcer>(
        scheduler, transports, Announcer::Where{options.network, options.interfaces}, counters, log,
        Announcer::Calls{[this] { return own_record(); }, [this](const HostRecord& record) { announced(record); },
                         [this](TroubleKind kind, OwnerId id, std::string_view name, std::string_view detail) {
                           troubles.note(kind, id, name, detail);
                         }});
  }
  periodic();
  return {};
}

/// With loopback interfaces only, no other host can connect.
Result<void> Node::Impl::listen(std::uint16_t port) {
  auto accepts = [this](std::unique_ptr<transport::TcpStream> stream) { return accept(std::move(stream)); };
  auto failed = lifetime.guard([this](const Error& error) {
    log.warning("listen", error.text + "; others cannot connect to this component any longer");
    listener.reset();
  });
  auto opened = transports.listen_tcp({is_loopback_only(options) ? "127.0.0.1" : "0.0.0.0", port}, accepts, failed);
  if (!opened) return fail(opened.error());
  listener = std::move(*opened);
  local = listener->local();
  return {};
}

}  // namespace rubicon::tuples::peis
