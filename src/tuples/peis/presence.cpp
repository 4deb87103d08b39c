#include "tuples/peis/presence.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "rubicon/summary.hpp"
#include "tuples/peis/own_session.h"

namespace rubicon::tuples::peis {

Presence::Presence(Start start, Scheduler& scheduler, Log log)
    : start_(std::move(start)),
      log_(std::move(log), scheduler),
      context_{start_.node.id, scheduler, log_, &start_.listener} {}

Presence::~Presence() {
  end();
}

Result<void> Presence::open(transport::Transports& transports) {
  auto opened = Node::open(start_.node, context_.scheduler, transports, log_.unlimited(), node_calls());
  if (!opened) return fail(opened.error());
  node_ = std::move(*opened);
  context_.node = node_.get();
  show_name();
  opened_ = context_.scheduler.now();
  return {};
}

NodeCallbacks Presence::node_calls() {
  // The listener may end the link while it is called: this then lives until the call is over.
  const auto during = [this](auto call) {
    return [this, call](auto&&... arguments) {
      if (!context_.listener) return;
      ++context_.calls;
      call(arguments...);
      --context_.calls;
    };
  };
  NodeCallbacks calls;
  calls.message = during([this](OwnerId from, Port port, ByteView body) {
    if (port == Port::kSetRemote || port == Port::kSetAppend) find_place(from);
    if (auto* session = find(from)) session->receive(port, body);
  });
  calls.host = during([this](HostEvent event, const Identity& host) { on_host(event, host); });
  calls.ready = during([this](OwnerId to) {
    if (auto* session = find(to)) session->ready();
  });
  calls.id_taken = during([this](const Identity& other) { on_id_taken(other); });
  return calls;
}

void Presence::end() {
  if (!std::exchange(context_.listener, nullptr)) return;
  for (const auto& [id, peer] : peers_) start_.policy.peer_down(id);
}

Session* Presence::find(OwnerId peer) {
  const auto found = peers_.find(peer);
  return found == peers_.end() ? nullptr : found->second.session.get();
}

std::vector<OwnerId> Presence::peers() const {
  std::vector<OwnerId> present;
  for (const auto& [id, peer] : peers_) present.push_back(id);
  return present;
}

void Presence::subscribe(const SubscriptionSpec& spec) {
  subscriptions_[spec.id] = spec;
  for (auto& [id, peer] : peers_) {
    if (!spec.pattern.owner || *spec.pattern.owner == id) peer.session->subscribe(spec);
  }
}

void Presence::unsubscribe(std::uint32_t id) {
  const auto gone = subscriptions_.extract(id);
  if (gone.empty()) return;
  const auto& owner = gone.mapped().pattern.owner;
  for (auto& [peer_id, peer] : peers_) {
    if (!owner || *owner == peer_id) peer.session->unsubscribe(id);
  }
}

/// Tools of 2013 show the name of each component; in `name@host!process` it has no signs of that form.
void Presence::show_name() {
  const auto summary = model::summary_from_json(start_.summary);
  if (!summary || summary->name.empty()) return;
  name_ = summary->name;
  std::replace_if(
      name_.begin(), name_.end(), [](char c) { return c == '@' || c == '!' || (c >= 0 && c <= ' '); }, '_');
  const auto& full_name = start_.node.full_name;
  const auto rest = full_name.substr(full_name.find('@'));
  if (node_ && !start_.is_stand_in)
    node_->rename(name_.substr(0, kMaxNameLength - std::min(rest.size(), kMaxNameLength)) + rest);
  if (refresh_.pending()) set_tuple("kernel.name", name_);
}

void Presence::describe(const std::string& summary) {
  start_.summary = summary;
  show_name();
  for (auto& [id, peer] : peers_) peer.session->describe(summary);
}

void Presence::on_host(HostEvent event, const Identity& host) {
  switch (event) {
    case HostEvent::kUp: return meet(host);
    case HostEvent::kHello: return part(host.id, PeerEvent::kLost), meet(host);
    case HostEvent::kLeft: return part(host.id, PeerEvent::kLeft);
    case HostEvent::kLost: return part(host.id, PeerEvent::kLost);
    case HostEvent::kBack: return again(host.id, &Session::back);
    case HostEvent::kForgot: return again(host.id, &Session::forgotten);
  }
}

/// What the peer has of this component may be less than it should be.
void Presence::again(OwnerId peer, void (Session::*begin)()) {
  auto* session = find(peer);
  if (!session) return;
  (session->*begin)();
  if (context_.listener) introduce(peer, *session);
}

/// A component that started a moment ago gives way to another one with its id. A stand-in always gives way to its
/// component; the component never gives way to a stand-in.
void Presence::on_id_taken(const Identity& other) {
  const bool meets_stand_in = other.full_name.starts_with(kStandInName);
  if (!start_.displaced || (meets_stand_in && !start_.is_stand_in)) return;
  const bool is_young = context_.scheduler.now() - opened_ < kYoung;
  if (!is_young && (!start_.is_stand_in || meets_stand_in)) return;
  context_.scheduler.post(start_.displaced);
}

bool Presence::is_here(const Identity& host) const {
  return host.host_name == start_.node.host_name && node_->is_here(host.id);
}

/// A kernel of this host that came through others may have connected since.
void Presence::find_place(OwnerId kernel) {
  const auto found = peers_.find(kernel);
  const auto* host = node_->host(kernel);
  if (found == peers_.end() || !host || host->hello || found->second.identity.host == start_.own_host) return;
  found->second.identity = identity_of(*host);
  start_.policy.peer_up(found->second.identity);
}

PeerIdentity Presence::identity_of(const Identity& host) const {
  if (host.hello) return {host.id, host.hello->incarnation, host.hello->host_id, start_.member};
  return {host.id, host.magic, is_here(host) ? start_.own_host : "peis " + host.host_name, start_.member};
}

std::unique_ptr<Session> Presence::make_session(const Identity& host) {
  if (host.hello) return std::make_unique<OwnSession>(context_, host.id);
  auto session = std::make_unique<KernelSession>(context_, host.id, view_);
  kernels_[host.id] = session.get();
  return session;
}

void Presence::meet(const Identity& host) {
  if (!context_.listener) return;
  if (host.hello && host.hello->version != Hello::kVersion) {
    log_.warning(fmt::format("version {}", number(host.id)),
                 fmt::format("component {} has version {} of our additions to PEIS, expected {}: ignored",
                             number(host.id), host.hello->version, Hello::kVersion));
    return;
  }
  const auto identity = identity_of(host);
  if (const auto may = start_.policy.may_join(identity); !may) {
    log_.warning(fmt::format("join {}", number(host.id)), may.error().text);
    return;
  }
  start_.policy.peer_up(identity);
  auto& peer = peers_[host.id];
  peer = {identity, make_session(host)};
  if (!host.hello) begin_observing();
  if (!context_.listener) return;
  introduce(host.id, *peer.session);
  context_.listener->on_peer(identity, PeerEvent::kUp);
  if (!host.hello && context_.listener) context_.listener->on_summary(host.id, kernel_summary(host));
}

void Presence::introduce(OwnerId id, Session& session) {
  for (const auto& one : subscriptions_) {
    if (const auto& owner = one.second.pattern.owner; !owner || *owner == id) session.subscribe(one.second);
  }
  if (!start_.summary.empty()) session.describe(start_.summary);
}

void Presence::part(OwnerId peer, PeerEvent how) {
  auto gone = peers_.extract(peer);
  if (gone.empty()) return;
  kernels_.erase(peer);
  start_.policy.peer_down(peer);
  gone.mapped().session->ended();
  if (context_.listener) context_.listener->on_peer(gone.mapped().identity, how);
}

namespace {

using namespace std::chrono_literals;

constexpr Duration kRefresh = 1s;
constexpr unsigned kTrafficEach = 5, kRoutesEach = 10;  ///< refreshes; as kernels (peis.md, section 1.11)
constexpr std::size_t kMaxTextLength = 256 * 1024;      ///< of a list in a tuple

}  // namespace

/// From the first kernel on: only they need all own keys.
void Presence::begin_observing() {
  if (refresh_.pending() || !context_.listener) return;
  set_first_tuples();
  refresh();
  context_.listener->on_subscribe(kLinkItself, {1, {context_.self, "**"}, {.passive = true}});
}

void Presence::set_first_tuples() {
  const auto& node = start_.node;
  set_tuple("kernel.id", std::to_string(number(node.id)));
  set_tuple("kernel.name", name_.empty() ? node.full_name.substr(0, node.full_name.find('@')) : name_);
  set_tuple("kernel.hostname", node.host_name);
  set_tuple("kernel.user", start_.user);
  set_tuple("kernel.version", fmt::format("rubicon {} (proto {})", RUBICON_VERSION, kProtocolVersion));
  set_tuple(kQuitKey, {});
  set_tuple("kernel.step-time", "0.0000");  // it waits for events instead
}

void Presence::set_tuple(std::string_view key, std::string value) {
  if (!view_.tuples.set(key, std::move(value), context_.scheduler.wall_now())) return;
  for (const auto& [id, kernel] : kernels_) kernel->push_kernel_tuple(std::string(key));
}

void Presence::refresh() {
  refresh_ = context_.scheduler.after(kRefresh, [this] { refresh(); });
  if (keys_known_ && std::exchange(keys_changed_, false)) show_keys();
  set_tuple("kernel.subscribers", subscribers_text());
  if (refreshes_ % kTrafficEach == 0) {
    const auto links = node_->links();
    const auto span = refreshes_ == 0 ? kRefresh : kTrafficEach * kRefresh;
    set_tuple("kernel.connections", connections_text(links, links_before_, span));
    set_tuple("kernel.traffic", traffic_text(links, links_before_, span));
    links_before_ = links;
  }
  if (refreshes_ % kRoutesEach == 0) set_tuple("kernel.routingTable", routing_text(node_->routes()));
  ++refreshes_;
}

/// No list before it is whole: a stand-in learns its keys some seconds after the first kernel asked for them.
void Presence::all_keys_known() {
  if (std::exchange(keys_known_, true)) return;
  keys_changed_ = false;
  show_keys();
}

void Presence::show_keys() {
  set_tuple("kernel.all-keys", view_.keys.list(KernelTuples::kNames, kMaxTextLength));
}

/// `(\n  ( <subscriber> <owner>.<key> )\n)\n`
std::string Presence::subscribers_text() const {
  std::string text = "(\n";
  for (const auto& [id, peer] : peers_) {
    for (const auto& pattern : peer.session->patterns()) {
      if (text.size() > kMaxTextLength) break;
      const auto key = pattern == "**" ? std::string_view() : std::string_view(pattern);
      text += fmt::format("  ( {} {}.{} )\n", number(id), number(context_.self), key);
    }
  }
  return text + ")\n";
}

void Presence::observe(std::span<const Change> changes) {
  const auto now = context_.scheduler.now();
  for (const auto& change : changes) {
    if (const auto* set = std::get_if<TupleSet>(&change)) {
      const std::string key(set->tuple.key);
      if (view_.keys.spelling(key) || !view_.keys.add(key)) continue;
      keys_changed_ = true;
      for (const auto& [id, kernel] : kernels_) kernel->key_added(key);
    } else if (const auto* gone = std::get_if<TupleGone>(&change)) {
      keys_changed_ |= view_.keys.remove(gone->key, now);
    } else if (std::holds_alternative<SnapshotEnd>(change)) {
      all_keys_known();
    }
  }
}

}  // namespace rubicon::tuples::peis
