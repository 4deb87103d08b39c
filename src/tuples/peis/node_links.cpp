#include "tuples/peis/node_links.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace rubicon::tuples::peis {

namespace {

constexpr std::size_t kMaxLinks = 256;
constexpr std::size_t kReservedLinks = 32;                 ///< besides, for those that this node establishes
constexpr std::size_t kMaxStrangers = 32;                  ///< accepted connections that have not sent who they are
constexpr std::size_t kMaxUnmet = 64;                      ///< those included, accepted ones without a host record
constexpr std::size_t kMaxUnmetOfHost = 8;                 ///< from one address of another host
constexpr Duration kRecordTime = std::chrono::seconds(5);  ///< from the connect message to the host record
constexpr Duration kClaimTime = std::chrono::seconds(1);   ///< for the record of one with the id of this node
constexpr int kPortsToTry = 100;

}  // namespace

NodeLinks::NodeLinks(NodeContext& context, const Hosts& hosts, Deliveries& deliveries, Callbacks calls)
    : context_(context),
      hosts_(hosts),
      deliveries_(deliveries),
      callbacks_(std::move(calls)),
      cleaning_(context.scheduler, [this] { over_.clear(); }) {}

void NodeLinks::end() {
  lifetime_.end();
  for (auto& [id, link] : links_) link.connection->close();
}

Result<void> NodeLinks::listen() {
  const auto first = context_.options.first_port;
  auto listening = listen(first);
  for (int i = 1; first != 0 && i < kPortsToTry && !listening; ++i) {
    if (listening.error().code != ErrorCode::kBusy || first + i > 0xffff) break;
    listening = listen(static_cast<std::uint16_t>(first + i));
  }
  return listening;
}

/// With loopback interfaces only, no other host can connect.
Result<void> NodeLinks::listen(std::uint16_t port) {
  auto accepts = [this](std::unique_ptr<transport::TcpStream> stream) { return accept(std::move(stream)); };
  auto failed = lifetime_.guard([this](const Error& error) {
    context_.log.warning("listen", error.text + "; others cannot connect to this component any longer");
    listener_.reset();
  });
  const auto* host = is_loopback_only(context_.options) ? "127.0.0.1" : "0.0.0.0";
  auto opened = context_.transports.listen_tcp({host, port}, accepts, failed);
  if (!opened) return fail(opened.error());
  listener_ = std::move(*opened);
  local_ = listener_->local();
  return {};
}

NodeLink* NodeLinks::find(LinkId id) {
  const auto found = links_.find(id);
  return found == links_.end() ? nullptr : &found->second;
}

bool NodeLinks::is_linked(OwnerId peer) const {
  return std::any_of(links_.begin(), links_.end(), [&](const auto& item) {
    const auto& link = item.second;  // what one that connected says of itself shows nothing before its record
    return link.peer == peer && (link.is_route() || link.initiated);
  });
}

std::size_t NodeLinks::strangers() const {
  return static_cast<std::size_t>(std::count_if(links_.begin(), links_.end(), [](const auto& item) {
    return !item.second.initiated && item.second.peer == OwnerId{};
  }));
}

bool NodeLinks::may_accept(const std::string& address) const {
  std::size_t all = 0, of_host = 0;
  for (const auto& [id, link] : links_) {
    if (link.initiated || link.is_route()) continue;
    ++all;
    if (link.connection->remote().address == address) ++of_host;
  }
  const bool is_local = address.starts_with("127.");
  return all < kMaxUnmet && strangers() < kMaxStrangers && (is_local || of_host < kMaxUnmetOfHost);
}

bool NodeLinks::has_room(std::size_t limit) const {
  const auto used = std::count_if(links_.begin(), links_.end(),
                                  [](const auto& item) { return item.second.initiated || item.second.is_route(); });
  return static_cast<std::size_t>(used) < limit;
}

bool NodeLinks::is_here(OwnerId host) const {
  return std::any_of(links_.begin(), links_.end(), [&](const auto& item) {
    const auto& address = item.second.connection->remote().address;
    const auto is_own = [&](const auto& interface) { return interface.address == address; };
    const auto& own = context_.options.interfaces;
    return item.second.peer == host && item.second.is_route() &&
           (address.starts_with("127.") || std::any_of(own.begin(), own.end(), is_own));
  });
}

bool NodeLinks::has_room_for(const NodeLink& link, OwnerId host) const {
  return link.initiated || is_linked(host) || has_room(kMaxLinks);
}

NodeLink& NodeLinks::make(bool initiated) {
  const LinkId id{++last_link_};
  ConnectionCallbacks events;
  const auto with = [this, id](auto call) {
    return [this, id, call](auto&&... arguments) {
      if (auto* found = find(id)) call(*found, arguments...);
    };
  };
  events.connected = with([this](NodeLink& link) { greet(link); });
  events.greeted = [this, id](const ConnectMessage& message) {
    auto* found = find(id);
    return found && greeted(*found, message);
  };
  events.package = with([this](NodeLink& link, const Package& package) { callbacks_.package(link, package); });
  events.closed = [this, id](Ending why, const Error& error) { closed(id, why, error); };
  events.room = [this] { callbacks_.room(); };
  events.quiet = with([this](NodeLink& link) { send(link, Routing::kLink, Port::kHello, {}); });
  auto& made = links_[id];
  made.id = id;
  made.initiated = initiated;
  made.connection = std::make_unique<Connection>(context_.scheduler, std::move(events));
  return made;
}

transport::TcpCallbacks NodeLinks::accept(std::unique_ptr<transport::TcpStream> stream) {
  const auto from = stream->remote().address;
  if (may_accept(from)) return make(false).connection->accept(std::move(stream));
  ++context_.counters.too_many_links;
  context_.log.warning("strangers", "connection from " + from + " refused: too many others have not sent who they are");
  return {};
}

bool NodeLinks::dial(const Target& target, const transport::Endpoint& to, std::uint32_t flags) {
  if (to == local_) return false;
  if (!has_room(kMaxLinks + kReservedLinks)) {
    ++context_.counters.too_many_links;
    return context_.log.warning("links", "no connection to " + transport::to_string(to) + ": too many connections"),
           false;
  }
  auto& link = make(true);
  const auto dialed =
      link.connection->dial(context_.transports, to, {context_.options.id, flags, context_.options.network});
  if (dialed) return link.target = target, true;
  context_.log.debug("dial " + transport::to_string(to), dialed.error().text);
  links_.erase(link.id);
  return false;
}

/// Whether the connect message is one of this network, of another component.
bool NodeLinks::greeted(NodeLink& link, const ConnectMessage& message) {
  const auto from = link.connection->remote();
  const auto name = fmt::format("component {} at {}", number(message.id), transport::to_string(from));
  if (message.network != context_.options.network) {
    ++context_.counters.foreign_networks;
    context_.troubles.note(TroubleKind::kForeignNetwork, message.id, transport::to_string(from), message.network);
    return context_.log.info("network " + name, fmt::format("{}: refused, its network is another one", name)), false;
  }
  if (message.id == context_.options.id) {
    ++context_.counters.own_id_seen;
    const bool is_self = std::any_of(links_.begin(), links_.end(),
                                     [&](const auto& item) { return item.second.connection->local() == from; });
    if (is_self) return false;
    // Its record follows. Without one it asks whether this node is there: closing is the answer.
    link.record_due = context_.scheduler.after(kClaimTime, [this, id = link.id] {
      if (auto* asked = find(id)) close(*asked);
    });
    return true;
  }
  const auto id = number(message.id);
  if (id == 0 || id > kMaxId) return ++context_.counters.bad_ids, false;
  if (!has_room(kMaxLinks)) {
    ++context_.counters.too_many_links;
    return context_.log.warning("links", name + ": refused, too many connections"), false;
  }
  link.peer = message.id;
  greet(link);
  return true;
}

/// Without its record a connection leads nowhere, but takes room.
void NodeLinks::greet(NodeLink& link) {
  callbacks_.greet(link);
  link.record_due = context_.scheduler.after(kRecordTime, [this, id = link.id] {
    auto* late = find(id);
    if (!late || late->is_route()) return;
    ++context_.counters.silent_links;
    const auto text = fmt::format("component {} at {} did not send who it is", number(late->peer),
                                  transport::to_string(late->connection->remote()));
    context_.log.warning("no record", text + ": connection closed");
    if (late->initiated) unreachable(late->target, Error{ErrorCode::kUnreachable, text});
    close(*late);
  });
}

void NodeLinks::close(NodeLink& link) {
  link.connection->close();
  remove(link.id, false);
}

void NodeLinks::close_each(const std::function<bool(const NodeLink&)>& which) {
  std::vector<LinkId> ids;
  for (const auto& [id, link] : links_) {
    if (which(link)) ids.push_back(id);
  }
  for (const auto id : ids) close(*find(id));
}

void NodeLinks::close_all(OwnerId peer) {
  close_each([peer](const NodeLink& link) { return link.peer == peer; });
}

void NodeLinks::close_former(OwnerId peer, std::uint32_t magic) {
  close_each(
      [peer, magic](const NodeLink& link) { return link.peer == peer && link.is_route() && link.magic != magic; });
}

void NodeLinks::close_duplicates(OwnerId peer) {
  NodeLink* by_us = nullptr;
  NodeLink* by_peer = nullptr;
  std::vector<LinkId> surplus;
  for (auto& [id, link] : links_) {
    if (link.peer != peer || !link.is_route()) continue;
    auto& newest = link.initiated ? by_us : by_peer;
    if (newest) surplus.push_back(newest->id);
    newest = &link;
  }
  if (by_us && by_peer && by_us->ours && by_peer->ours)
    surplus.push_back((context_.options.id < peer ? by_peer : by_us)->id);
  for (const auto id : surplus) close(*find(id));
}

void NodeLinks::widen(OwnerId peer, Duration lease) {
  for (auto& [id, link] : links_) {
    if (link.peer != peer || !link.is_route()) continue;
    link.ours = true;
    link.connection->widen(lease, context_.options.hello.lease);
  }
}

std::string NodeLinks::address_of(const Target& target) const {
  if (target.configured < 0) return {};
  return context_.options.connect.at(static_cast<std::size_t>(target.configured));
}

void NodeLinks::unreachable(const Target& target, const Error& error) {
  const auto* record = hosts_.record(target.host);
  context_.troubles.note(TroubleKind::kUnreachable, target.host, record ? record->full_name : address_of(target),
                         error.text);
}

void NodeLinks::closed(LinkId id, Ending why, const Error& error) {
  const auto* ended = find(id);
  if (ended && ended->initiated && !ended->is_route()) unreachable(ended->target, error);
  if (why == Ending::kStuck) ++context_.counters.stuck_links;
  if (why == Ending::kSilent) ++context_.counters.silent_links;
  if (why == Ending::kStrange) {
    const bool version = error.code == ErrorCode::kUnsupported;
    ++(version ? context_.counters.foreign_versions : context_.counters.bad_streams);
    if (version) context_.troubles.note(TroubleKind::kForeignVersion, ended ? ended->peer : OwnerId{}, {}, error.text);
    context_.log.warning("strange bytes", error.text);
  } else {
    const bool is_odd = why == Ending::kStuck || why == Ending::kSilent;
    if (is_odd)
      context_.log.info("dead connection",
                        fmt::format("component {}: {}", number(ended ? ended->peer : OwnerId{}), error.text));
    context_.log.debug("connection", error.text);
  }
  remove(id, true);
}

void NodeLinks::remove(LinkId id, bool broken) {
  auto gone = links_.extract(id);
  if (gone.empty()) return;
  auto& link = gone.mapped();
  const auto heard = link.connection->heard();
  over_.push_back(std::move(link.connection));
  cleaning_.request();
  callbacks_.ended(link, heard, broken);
}

void NodeLinks::send(NodeLink& link, Routing routing, Port port, ByteView body) {
  Bytes package;
  append_package(package, deliveries_.next_header(routing, port, kEveryone), body);
  if (!link.connection->send(package, true)) ++context_.counters.queue_full;
}

void NodeLinks::flood(ByteView package, std::optional<LinkId> except) {
  for (auto& [id, link] : links_) {
    if (id == except || !link.is_route()) continue;
    if (!link.connection->send(package, false)) ++context_.counters.queue_full;
  }
}

}  // namespace rubicon::tuples::peis
