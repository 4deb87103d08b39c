#include "proxy/admission/roaming_claims.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <tuple>
#include <vector>

#include "base/text.h"
#include "gateway/message_rights.h"
#include "model/json_members.h"
#include "model/json_text.h"
#include "proxy/tuple_text.h"
#include "rubicon/key.hpp"
#include "tuples/peer_policy.h"

namespace rubicon::proxy::admission {

namespace {

using PlainTree = nlohmann::json;

constexpr std::size_t kMaxClaim = 4096;
constexpr std::size_t kMaxAddress = 255;
/// 2200-01-01 in seconds since 1970: microseconds up to it are exact in a double.
constexpr double kMaxTime = 7258118400.0;

bool is_part(const std::string& text) {
  return text == model::to_key_part(text);
}

Error wrong(std::string_view what) {
  return {ErrorCode::kInvalid, fmt::format("a roaming claim needs {}", what)};
}

}  // namespace

bool better(const Claim& one, const Claim& other) {
  return std::tie(other.since, one.island, one.network) < std::tie(one.since, other.island, other.network);
}

std::string claim_text(const Claim& claim) {
  std::string out = fmt::format("{{\"key\":\"{}\",\"network\":\"{}\",\"device\":\"{}\",\"address\":", claim.key,
                                claim.network, claim.device);
  model::append_json(claim.address, out);
  out += ",\"since\":";
  model::append_seconds(claim.since, out);
  out += fmt::format(",\"reachable\":{}}}", claim.reachable);
  return out;
}

Result<Claim> parse_claim(OwnerId island, std::string_view text) {
  const auto tree = text.size() > kMaxClaim ? PlainTree(PlainTree::value_t::discarded) : model::parse_json(text);
  if (!tree.is_object()) return fail(wrong("a JSON object of at most 4096 bytes"));
  const auto key = model::find_text(tree, "key"), network = model::find_text(tree, "network"),
             device = model::find_text(tree, "device"), address = model::find_text(tree, "address");
  if (!key || !model::check_key(*key)) return fail(wrong("the key of the device"));
  if (!network || !device || !is_part(*network) || !is_part(*device)) {
    return fail(wrong("the key parts of network and device"));
  }
  if (!address || address->empty() || address->size() > kMaxAddress) {
    return fail(wrong("an address of 1 to 255 bytes"));
  }
  const auto since = tree.find("since");
  const double seconds = since != tree.end() && since->is_number() ? since->get<double>() : -1;
  if (!(seconds >= 0 && seconds <= kMaxTime)) return fail(wrong("since, in seconds from 1970 to 2200"));
  const auto reachable = tree.find("reachable");
  const bool heard = reachable != tree.end() && reachable->is_boolean() && reachable->get<bool>();
  return Claim{island,  *key,     *network,
               *device, *address, WallTime(std::chrono::microseconds(std::llround(seconds * 1e6))),
               heard};
}

std::string claim_key(const Identity& identity) {
  return fmt::format("ROAMING.{}.{}", identity.domain, model::to_key_part(identity.address));
}

bool is_claim_key(std::string_view key, const Identity& identity) {
  const auto first = claim_key(identity);
  if (!key.starts_with(first)) return false;
  key.remove_prefix(first.size());
  if (key.empty()) return true;
  const auto twin = key.front() == '-' ? base::parse_number<std::uint32_t>(key.substr(1)) : std::nullopt;
  return twin && *twin >= 2;
}

namespace {

constexpr tuples::SetOptions kClaimOptions{"application/json", {}, {}};
/// How long an island that went down without leaving keeps its devices.
constexpr Duration kGrace = std::chrono::seconds(10);
/// Claims of other islands that are followed; devices of further ones may be listed twice.
constexpr std::size_t kMaxClaims = 200'000;
/// Clocks of other islands that are further ahead than this are reported.
constexpr Duration kMaxClockError = std::chrono::minutes(1);

}  // namespace

RoamingClaims::RoamingClaims(ProxyContext& context, Callbacks callbacks)
    : context_(context),
      callbacks_(std::move(callbacks)),
      peers_watch_(
          context.space.watch_peers([this](OwnerId island, tuples::PeerEvent event) { peer(island, event); })) {}

void RoamingClaims::follow(const std::set<std::string>& domains) {
  for (auto it = domains_.begin(); it != domains_.end();) {
    if (domains.contains(it->first)) {
      ++it;
      continue;
    }
    const auto& domain = it->first;
    std::erase_if(theirs_, [&](const auto& one) { return one.second.domain == domain; });
    std::erase_if(entries_, [&](const auto& one) { return one.first.domain == domain; });
    it = domains_.erase(it);
  }
  for (const auto& domain : domains) {
    if (domains_.contains(domain)) continue;
    auto& followed = domains_[domain];
    followed.since = context_.clock.now().steady;
    followed.subscription =
        context_.space.subscribe({std::nullopt, fmt::format("ROAMING.{}.*", domain)}, {.passive = true},
                                 [this, domain](const tuples::Event& event) { take(domain, event); });
  }
}

void RoamingClaims::take(const std::string& domain, const tuples::Event& event) {
  const auto& tuple = event.tuple;
  if (tuple.owner == context_.space.self() || !model::is_island(tuple.owner)) return;
  const OtherKey where{tuple.owner, std::string(tuple.key)};
  if (event.kind != tuples::EventKind::kSet) return drop(where);
  auto claim = read_claim(domain, tuple);
  if (!claim) {
    context_.warn(fmt::format("roaming/{}", number(tuple.owner)),
                  fmt::format("claim {} of island {}: {}", tuple.key, number(tuple.owner), claim.error().text));
    return drop(where);
  }
  check_clock(*claim);
  const Identity identity{domain, claim->address};
  const auto known = theirs_.find(where);
  const bool is_new = known == theirs_.end();
  if (!is_new && known->second != identity) drop(where);
  if (is_new && theirs_.size() >= kMaxClaims) {
    return context_.warn("roaming", fmt::format("more than {} claims of other islands: some are ignored", kMaxClaims));
  }
  store(identity, where.second, std::move(*claim));
}

Result<Claim> RoamingClaims::read_claim(const std::string& domain, const tuples::TupleView& tuple) const {
  if (!gateway::is_true_island(context_.space, tuple.owner))
    return fail(ErrorCode::kRefused, "its wire does not vouch for that component as an island");
  auto claim = parse_claim(tuple.owner, tuple.value);
  if (!claim) return claim;
  const Identity identity{domain, claim->address};
  if (!is_claim_key(tuple.key, identity))
    return fail(ErrorCode::kInvalid, fmt::format("it is about address {}, expected the key {}",
                                                 model::quoted(claim->address), claim_key(identity)));
  auto may = may_claim(identity, tuple);
  if (may) return claim;
  record(tuple.owner, tuple.key, may);
  return fail(std::move(may.error()));
}

void RoamingClaims::record(OwnerId island, std::string_view tuple, const Result<void>& answer) const {
  auto* judge = tuples::SpaceRights::judge(context_.space);
  const auto* who = tuples::SpaceRights::member_of(context_.space, island);
  if (!judge || !who) return;
  judge->record(*who, {island, tuples::SpaceRights::policy(context_.space).host(island), "set", tuple, {}}, answer);
}

/// A member that may claim a device may set its claim here too. By this set its commands follow the device. A twin is
/// denied by its own key too.
Result<void> RoamingClaims::may_claim(const Identity& identity, const tuples::TupleView& tuple) const {
  auto* judge = tuples::SpaceRights::judge(context_.space);
  if (judge == nullptr) return {};
  tuples::RemoteSet set;
  set.from = tuple.owner;
  set.owner = context_.space.self();
  set.key = claim_key(identity);
  const auto* who = tuples::SpaceRights::member_of(context_.space, tuple.owner);
  auto may = tuples::SpaceRights::policy(context_.space).may_set(set);
  if (!may || !who) return may;
  const std::vector<std::string> keys{set.key, std::string(tuple.key)};
  return judge->may_by_names(*who, tuples::Act::kSet, keys);
}

void RoamingClaims::check_clock(const Claim& claim) {
  const auto now = context_.clock.now().wall;
  if (claim.since <= now || claim.since - now < kMaxClockError) return;
  context_.warn(fmt::format("roaming/clock/{}", number(claim.island)),
                fmt::format("island {} claims that {} joined {} s from now: check the clocks of both islands",
                            number(claim.island), model::quoted(claim.address),
                            std::chrono::duration_cast<std::chrono::seconds>(claim.since - now).count()));
}

void RoamingClaims::store(const Identity& identity, const std::string& tuple, Claim claim) {
  const auto island = claim.island;
  theirs_[{island, tuple}] = identity;
  peers_.try_emplace(island);
  auto& other = entries_[identity].others[island];
  auto renewed_at = other.renewed_at;
  const bool renewed = other.tuple.empty() || other.claim.since != claim.since;
  if (renewed) renewed_at = is_recent(island, identity.domain) ? context_.clock.now().steady : SteadyTime::min();
  other = {std::move(claim), tuple, renewed_at, true};
  callbacks_.claimed(Identity(identity));
}

/// Whether a claim that arrives now was published now. Just after we subscribed, or the island came up, it may be old.
bool RoamingClaims::is_recent(OwnerId island, const std::string& domain) const {
  const auto before = context_.clock.now().steady - kRoamingSettles;
  return peers_.at(island).since <= before && domains_.at(domain).since <= before;
}

void RoamingClaims::drop(const OtherKey& claim) {
  const auto node = theirs_.extract(claim);
  if (!node) return;
  const auto& identity = node.mapped();
  const auto entry = entries_.find(identity);
  if (entry == entries_.end()) return;
  const auto other = entry->second.others.find(claim.first);
  if (other == entry->second.others.end() || other->second.tuple != claim.second) return;
  entry->second.others.erase(other);
  entry->second.former = claim.first;
  callbacks_.unclaimed(identity);
  tidy(identity);
}

void RoamingClaims::tidy(const Identity& identity) {
  const auto entry = entries_.find(identity);
  if (entry != entries_.end() && entry->second.others.empty() && entry->second.tuple.empty()) entries_.erase(entry);
}

void RoamingClaims::peer(OwnerId island, tuples::PeerEvent event) {
  if (!model::is_island(island)) return;
  const auto now = context_.clock.now().steady;
  auto& peer = peers_[island];
  peer.since = now;
  peer.up = event == tuples::PeerEvent::kUp;
  peer.left = event == tuples::PeerEvent::kLeft;
  peer.settled.cancel();
  if (!peer.up) return;
  each_of(island, [](const Identity&, Other& other) { other.fresh = false; });
  peer.settled = context_.scheduler.after(kRoamingSettles, [this, island] {
    context_.clock.refresh();
    std::vector<Identity> all;
    each_of(island, [&all](const Identity& identity, Other&) { all.push_back(identity); });
    for (const auto& identity : all) callbacks_.claimed(identity);
  });
}

void RoamingClaims::each_of(OwnerId island, const std::function<void(const Identity&, Other&)>& visit) {
  for (auto it = theirs_.lower_bound({island, {}}); it != theirs_.end() && it->first.first == island; ++it) {
    const auto entry = entries_.find(it->second);
    if (entry == entries_.end()) continue;
    const auto other = entry->second.others.find(island);
    if (other != entry->second.others.end()) visit(it->second, other->second);
  }
}

RoamingClaims::Presence RoamingClaims::presence(const Other& other) const {
  const auto found = peers_.find(other.claim.island);
  if (found == peers_.end()) return Presence::kGone;
  const auto& peer = found->second;
  const auto age = context_.clock.now().steady - peer.since;
  if (peer.up) return other.fresh || age >= kRoamingSettles ? Presence::kHere : Presence::kBack;
  return peer.left || age >= kGrace ? Presence::kGone : Presence::kLost;
}

void RoamingClaims::each(const Identity& identity, const std::function<void(const Other&, Presence)>& visit) const {
  const auto entry = entries_.find(identity);
  if (entry == entries_.end()) return;
  for (const auto& [island, other] : entry->second.others) visit(other, presence(other));
}

WallTime RoamingClaims::newest(const Identity& identity) const {
  WallTime newest{};
  each(identity, [&newest](const Other& other, Presence) { newest = std::max(newest, other.claim.since); });
  return newest;
}

bool RoamingClaims::has_claimed(const Identity& identity, OwnerId island) const {
  const auto entry = entries_.find(identity);
  return entry != entries_.end() && (entry->second.former == island || entry->second.others.contains(island));
}

/// Two addresses may give one key part: readers compare the address in the value.
std::string RoamingClaims::free_tuple(const Identity& identity) const {
  const auto first = claim_key(identity);
  auto key = first;
  for (int twin = 2; own_.contains(key); ++twin) key = fmt::format("{}-{}", first, twin);
  return key;
}

std::string RoamingClaims::publish(const Identity& identity, const Claim& own) {
  auto& entry = entries_[identity];
  auto text = claim_text(own);
  if (text == entry.text) return entry.tuple;
  if (entry.tuple.empty()) entry.tuple = free_tuple(identity);
  own_[entry.tuple] = identity;
  entry.text = std::move(text);
  const auto set = context_.space.set(entry.tuple, entry.text, kClaimOptions);
  if (!set) context_.warn("roaming", fmt::format("{}: {}", entry.tuple, set.error().text));
  return entry.tuple;
}

void RoamingClaims::withdraw(const Identity& identity) {
  const auto entry = entries_.find(identity);
  if (entry == entries_.end() || entry->second.tuple.empty()) return;
  std::ignore = context_.space.erase(entry->second.tuple);
  own_.erase(entry->second.tuple);
  entry->second.tuple.clear();
  entry->second.text.clear();
  tidy(identity);
}

const Identity* RoamingClaims::identity_of_own(const std::string& tuple) const {
  const auto found = own_.find(tuple);
  return found == own_.end() ? nullptr : &found->second;
}

}  // namespace rubicon::proxy::admission
