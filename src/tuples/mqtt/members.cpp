#include "base/text.h"
#include "tuples/mqtt/mqtt_link.h"

namespace rubicon::tuples::mqtt {

// Who others are.

namespace {

/// Ids from here on are free: an id below is that of an island.
constexpr std::uint32_t kFirstFreeId = 65536;

}  // namespace

/// The user that the broker vouches for.
std::shared_ptr<const Member> member_of(const SpaceOptions& options, const std::string& user) {
  if (options.realm) return options.realm->member(user);
  if (user == kAnonymous) return nullptr;
  auto member = std::make_shared<Member>();
  member->name = user;
  member->ids.push_back({kFirstFreeId, 0xffffffff});
  constexpr std::string_view kIsland = "island-";
  if (!user.starts_with(kIsland)) return member;
  const auto id = base::parse_number<std::uint32_t>(user.substr(kIsland.size()));
  if (id && *id < kFirstFreeId) member->ids.push_back({*id, *id});
  return member;
}

/// nullptr where nobody vouches for the user.
std::shared_ptr<const Member> MqttEcology::vouched_member(const std::string& user) const {
  return vouched_ || options_.trust_broker ? member_of(options_, user) : nullptr;
}

/// Where somebody vouches for users.
bool MqttEcology::may_have(const std::string& user, OwnerId id) const {
  if (!options_.judge && !options_.realm) return true;
  const auto member = member_of(options_, user);
  return member && member->may_use(id);
}

bool MqttEcology::may_stand_in(OwnerId carrier, OwnerId id) const {
  const auto at = presence_.reached(carrier);
  return at && may_have(at->line.user, id);
}

void MqttEcology::open_documents() {
  realm_changes_ = options_.realm->watch([this] { judge_again(); });
  Documents::Calls calls;
  calls.subscribe = [this](const std::string& filter) { std::ignore = uplink_.line()->subscribe(filter, 0); };
  calls.publish = [this](std::string topic, std::string payload) {
    std::ignore = publish({std::move(topic), std::move(payload), true, 1, {}, {}, 0});
  };
  documents_ =
      std::make_unique<Documents>(topics_, uplink_.broker().user, *options_.realm, scheduler_, log_, std::move(calls));
}

/// Who may be here no longer is lost; who stays has its new rights.
void MqttEcology::judge_again() {
  presence_.review_all();
  each_link([](MqttLink& link) { link.judge_again(); });
}

void MqttLink::judge_again() {
  if (is_stand_in() && ecology_.options_.realm && !ecology_.may_have(ecology_.own_.user, who_.id)) return displace();
  for (auto& [id, peer] : peers_) {
    if (!peer.at || peer.identity.own_process) continue;
    auto member = ecology_.vouched_member(peer.at->line.user);
    if (member == peer.identity.member) continue;
    peer.identity.member = std::move(member);
    policy_->peer_up(as_judged(peer.identity));
  }
}

}  // namespace rubicon::tuples::mqtt
