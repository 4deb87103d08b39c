#include <fmt/format.h>

#include "tuples/peis/presence.h"

namespace rubicon::tuples::peis {

namespace {

using namespace std::chrono_literals;

constexpr Duration kRefresh = 1s;
constexpr unsigned kTrafficEach = 5, kRoutesEach = 10;  ///< refreshes; as kernels (peis.md, section 1.11)
constexpr std::size_t kLongestText = 256 * 1024;        ///< of a list in a tuple

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
  set_tuple("kernel.all-keys", view_.keys.list(KernelTuples::kNames, kLongestText));
}

/// `(\n  ( <subscriber> <owner>.<key> )\n)\n`
std::string Presence::subscribers_text() const {
  std::string text = "(\n";
  for (const auto& [id, peer] : peers_) {
    for (const auto& pattern : peer.session->patterns()) {
      if (text.size() > kLongestText) break;
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
