#include "tuples/peis/peis_link.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "tuples/peer_policy.h"
#include "tuples/peis/session.h"
#include "tuples/refusals.h"

namespace rubicon::tuples::peis {

namespace {

/// Pause before the node is opened again after an error.
constexpr Duration kRetryOpen = std::chrono::seconds(1);

/// The number of this start of a kernel: looks random, and differs from that of the start before.
std::uint32_t magic_of(OwnerId id, std::uint64_t incarnation, const std::string& process, std::uint32_t before) {
  auto mixed = (incarnation + number(id) * 0x9e3779b97f4a7c15U) * 0xbf58476d1ce4e5b9U;
  for (const char c : process) mixed = (mixed ^ static_cast<unsigned char>(c)) * 0x100000001b3U;
  mixed ^= mixed >> 31;
  auto magic = static_cast<std::uint32_t>(mixed >> 32) & kMaxId;
  while (magic == 0 || magic == before) magic = (magic + 1) & kMaxId;
  return magic;
}

std::shared_ptr<const Member> everybody_there(const PeisOptions& options) {
  return options.judge ? std::make_shared<const Member>(Member{std::string(kPeisMember)}) : nullptr;
}

std::unique_ptr<PeerPolicy> make_policy(OwnerId self, const PeisLink::Settings& settings, const Log& log) {
  const auto& options = settings.options;
  if (options.judge) return std::make_unique<MemberPolicy>(self, options.judge, everybody_there(options));
  return std::make_unique<DeclaredHostPolicy>(self, settings.machine.host_id, options.trust_lan, log);
}

}  // namespace

PeisLink::PeisLink(OwnerId self, Settings settings, Scheduler& scheduler, transport::Transports& transports,
                   base::LogSink& log, std::function<void()> displaced, std::shared_ptr<void> token)
    : self_(self),
      settings_(std::move(settings)),
      scheduler_(scheduler),
      transports_(transports),
      log_(log, "peis"),
      policy_(make_policy(self, settings_, log_)),
      displaced_(std::move(displaced)),
      token_(std::move(token)) {}

PeisLink::~PeisLink() {
  detach();
}

void PeisLink::attach(LinkListener& listener, std::uint64_t incarnation) {
  detach();
  incarnation_ = std::max(incarnation, incarnation_ + 1);
  magic_ = magic_of(self_, incarnation_, settings_.machine.process, magic_);
  presence_ = std::make_unique<Presence>(
      Presence::Start{node_options(), listener, *policy_, summary_, everybody_there(settings_.options),
                      settings_.machine.user, settings_.machine.host_id, !settings_.shown_host.empty(), displaced_},
      scheduler_, log_);
  open();
}

void PeisLink::open() {
  const auto opened = presence_->open(transports_);
  if (opened) return;
  log_.error(opened.error().text);
  retry_ = scheduler_.after(kRetryOpen, [this] { open(); });
}

NodeOptions PeisLink::node_options() const {
  const auto& options = settings_.options;
  NodeOptions node;
  node.id = self_;
  node.magic = magic_;
  node.network = options.network;
  node.host_name = settings_.machine.host_name;
  const bool is_stand_in = !settings_.shown_host.empty();
  const auto name = is_stand_in ? Presence::kStandInName : std::string_view("rubicon");
  node.full_name = fmt::format("{}@{}!{}", name, node.host_name, settings_.machine.process).substr(0, kMaxNameLength);
  node.hello = {Hello::kVersion, options.lease, incarnation_,
                is_stand_in ? settings_.shown_host : settings_.machine.host_id};
  node.first_port = options.listen;
  node.multicast = options.multicast;
  node.interfaces = settings_.interfaces;
  node.connect = options.connect;
  return node;
}

void PeisLink::detach() {
  retry_.cancel();
  if (!presence_) return;
  presence_->end();
  if (!presence_->is_busy()) return presence_.reset();
  scheduler_.post([over = std::shared_ptr<Presence>(std::move(presence_))] {});
}

/// A component that is gone has no use for them.
bool PeisLink::publish(OwnerId subscriber, std::span<const Change> changes) {
  if (subscriber == kLinkItself) {
    if (presence_) presence_->observe(changes);
    return true;
  }
  auto* session = presence_ ? presence_->find(subscriber) : nullptr;
  if (!session) return true;
  if (session->is_full()) return false;
  for (const auto& change : changes) session->publish(change);
  return true;
}

void PeisLink::subscribe(const SubscriptionSpec& spec) {
  if (presence_) presence_->subscribe(spec);
}

void PeisLink::unsubscribe(std::uint32_t id) {
  if (presence_) presence_->unsubscribe(id);
}

Result<void> PeisLink::remote_set(const RemoteSet& set) {
  if (auto* session = presence_ ? presence_->find(set.owner) : nullptr) return session->remote_set(set);
  return fail(no_component(set.owner));
}

void PeisLink::reply(const Reply& reply) {
  if (auto* session = presence_ ? presence_->find(reply.to) : nullptr) session->reply(reply);
}

std::vector<OwnerId> PeisLink::peers() const {
  return presence_ ? presence_->peers() : std::vector<OwnerId>();
}

void PeisLink::each_counter(const std::function<void(std::string_view name, std::uint64_t value)>& visit) const {
  if (!presence_) return;
  const CounterVisit with_engine = [&](std::string_view name, std::uint64_t value) {
    visit(fmt::format("peis-{}", name), value);
  };
  if (const auto* node = presence_->node()) peis::each_counter(node->counters(), with_engine);
  peis::each_counter(presence_->counters(), with_engine);
}

void PeisLink::describe(std::string summary) {
  if (summary == summary_) return;
  summary_ = std::move(summary);
  if (presence_) presence_->describe(summary_);
}

}  // namespace rubicon::tuples::peis
