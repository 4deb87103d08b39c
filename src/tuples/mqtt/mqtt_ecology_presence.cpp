#include <fmt/format.h>

#include <random>

#include "base/text.h"
#include "tuples/mqtt/mqtt_ecology.h"
#include "tuples/mqtt/mqtt_link.h"

namespace rubicon::tuples::mqtt {

namespace {

/// Retained messages are written again before brokers forget them.
constexpr Duration kShowAgain = std::chrono::minutes(25);
constexpr Duration kLook = std::chrono::seconds(1);
/// After this number of changes at once some may have been dropped, so presence is read again.
constexpr unsigned kManyChanges = 500;
constexpr Duration kSeldom = std::chrono::seconds(30);
/// For the own user: the most connections that are examined, the most components of each, and how long one may be
/// silent.
constexpr std::size_t kMaxOwnLines = 256, kMaxOwnIds = 256;
constexpr Duration kLeftFor = std::chrono::seconds(60);
/// Of a component that lives.
constexpr Duration kAnswerWithin = std::chrono::seconds(3);

std::uint64_t random_number() {
  std::random_device source;
  return static_cast<std::uint64_t>(source()) << 31 | source();
}

struct Check final : distant::FrameReader {
  void on_identity_check(const distant::IdentityCheck& check) override { found = check; }
  std::optional<distant::IdentityCheck> found;
};

}  // namespace

// -- what this process shows

void MqttEcology::show_all() {
  shown_at_ = scheduler_.now();
  publish(topics_.line(own_), line_text({count_, options_.lease}), true);
  links_.each([this](const MqttLink& link) { show(link); });
}

/// What earlier connections of this process showed; the broker's own message for their end may come later.
void MqttEcology::empty_former() {
  for (const auto& line : std::exchange(former_, {})) {
    for (const auto id : presence_.shown_on(line)) publish(topics_.component(line, id), {}, true);
    publish(topics_.line(line), {}, true);
  }
}

void MqttEcology::show(const MqttLink& link) {
  show_here_soon_.request();
  if (!publish(topics_.component(own_, link.id()), component_text(link.shown()), true)) show_soon();
}

void MqttEcology::show_soon() {
  shown_at_ = scheduler_.now() - 2 * kShowAgain;
}

/// First publishes that it leaves, so that no component takes it for lost.
void MqttEcology::hide(const MqttLink& link) {
  show_here_soon_.request();
  const auto topic = topics_.component(own_, link.id());
  publish(topic, std::string(kLeft), false);
  publish(topic, {}, true);
}

/// Brokers of version 3.1.1 keep what a killed process showed: its user empties it.
void MqttEcology::note_own(const Topics::Presence& at, std::uint64_t incarnation, bool here) {
  if (at.line == own_) {  // another one of this user took it for dead
    const auto* link = at.component ? links_.find(*at.component) : nullptr;
    if (!here && (!at.component || (link && link->attached()))) show_soon();
    return;
  }
  if (answers_ || (own_lines_.size() >= kMaxOwnLines && !own_lines_.contains(at.line))) return;
  const auto [found, is_new] = own_lines_.try_emplace(at.line);
  auto& one = found->second;
  if (is_new || (!at.component && one.here != here)) one.since = scheduler_.now();
  if (!at.component) {
    one.here = here;
  } else if (!here) {
    one.ids.erase(*at.component);
  } else if (one.ids.size() < kMaxOwnIds) {
    one.ids[*at.component] = incarnation;
  }
  if (!one.here && one.ids.empty()) own_lines_.erase(found);
}

/// A living connection answers for one of its components. A connection without components shows little, and cannot be
/// asked.
void MqttEcology::empty_leftovers() {
  for (auto next = own_lines_.begin(); next != own_lines_.end();) {
    const auto now = next++;
    const auto& [line, one] = *now;
    if (one.here && (one.heard || one.ids.empty() || links_.all().empty())) continue;
    if (scheduler_.now() - one.since < kLeftFor) {
      const auto& [id, incarnation] = *one.ids.begin();
      const auto* asker = links_.find(id);
      if (one.here) ask(asker ? *asker : *links_.all().begin()->second, id, {line, {incarnation, {}, {}}});
      continue;
    }
    for (const auto& [id, incarnation] : one.ids) publish(topics_.component(line, id), {}, true);
    publish(topics_.line(line), {}, true);
    own_lines_.erase(now);
  }
}

// -- who has an id, and who answers

/// Whether a component lives.
void MqttEcology::ask(const MqttLink& asker, OwnerId id, const Reached& who) {
  auto& question = questions_[{id, who.line}];
  // Asked again before its answer came: that still counts.
  if (question.incarnation != who.shown.incarnation || question.asker != asker.id())
    question = {random_number(), who.shown.incarnation, asker.id(), scheduler_.now()};
  distant::FrameWriter entry;
  entry.add(distant::IdentityCheck{false, question.number});
  FrameHead head;
  head.source = asker.id();
  head.source_incarnation = asker.incarnation();
  head.target = id;
  head.target_incarnation = who.shown.incarnation;
  send_to(who.line, head, entry.view());
}

/// A living component answers the question.
void MqttEcology::on_check(const Line& from, const FrameHead& head, ByteView entries) {
  Check check;
  if (!distant::read_frame(entries, head.source, head.target, check) || !check.found) return;
  if (check.found->is_answer) return on_answer(from, head, check.found->number);
  // A stand-in gives way: it ends no component.
  if (const auto* asked = links_.find(head.target); head.source == head.target && asked && asked->is_stand_in()) return;
  distant::FrameWriter answer;
  answer.add(distant::IdentityCheck{true, check.found->number});
  FrameHead back;
  back.source = head.target;
  back.source_incarnation = head.target_incarnation;
  back.target = head.source;
  back.target_incarnation = head.source_incarnation;
  send_to(from, back, answer.view());
}

/// Of the start that was asked, from where it was asked. A presence of an earlier start displaces the own component.
void MqttEcology::on_answer(const Line& from, const FrameHead& head, std::uint64_t number) {
  const auto question = questions_.extract({head.source, from});
  if (question.empty() || question.mapped().number != number ||
      question.mapped().incarnation != head.source_incarnation || question.mapped().asker != head.target)
    return;
  if (const auto suspect = suspects_.find(head.source); suspect != suspects_.end())
    suspect->second = {SteadyTime::max(), scheduler_.now()};
  presence_.doubt(from, head.source, false);
  if (head.source != head.target || head.source_incarnation >= head.target_incarnation) return;
  if (auto* link = links_.find(head.target)) link->displace();
}

/// Another component with the id of an own one that began before it. A presence of another user ends no component.
void MqttEcology::ask_rivals() {
  links_.each([this](const MqttLink& link) {
    for (const auto& other : presence_.all_with(link.id())) {
      if (other->line == own_ || other->shown.incarnation >= link.incarnation()) continue;
      if (other->line.user == own_.user) {
        ask(link, link.id(), *other);
      } else {
        log_.warning(fmt::format("rival {}", number(link.id())),
                     fmt::format("user {} shows a component {}, too: give one of them another id", other->line.user,
                                 number(link.id())));
      }
    }
  });
}

/// Components that do not acknowledge, or of which two starts are shown, are asked; one that does not answer is gone.
void MqttEcology::look_at_suspects() {
  const auto now = scheduler_.now();
  std::map<OwnerId, Suspect> suspects;
  std::vector<std::pair<OwnerId, const MqttLink*>> unasked;
  std::vector<OwnerId> over;
  const auto look_at = [&](OwnerId id, const MqttLink& asker) {
    if (const auto* own = links_.find(id); own && own->attached()) return;
    const auto known = suspects_.find(id);
    const auto [found, is_new] = suspects.emplace(id, known == suspects_.end() ? Suspect() : known->second);
    if (!is_new) return;
    auto& suspect = found->second;
    const bool asked = suspect.asked != SteadyTime::max();
    if (asked && now - suspect.asked >= kAnswerWithin) over.push_back(id);
    if (!asked && now - suspect.answered >= options_.lease - kAnswerWithin) {
      suspect.asked = now;
      unasked.emplace_back(id, &asker);
    }
  };
  links_.each([&](const MqttLink& link) {
    for (const auto id : link.silent(options_.lease - kAnswerWithin)) look_at(id, link);
  });
  for (const auto id : presence_.contested()) {
    if (!links_.all().empty() && !links_.find(id)) look_at(id, *links_.all().begin()->second);
  }
  suspects_ = std::move(suspects);
  for (const auto& [id, link] : unasked) {
    if (const auto who = presence_.reached(id)) ask(*link, id, *who);
  }
  const auto alive = lifetime_.watch();
  for (const auto id : over) {
    if (const auto who = alive.ended() ? nullptr : presence_.reached(id)) presence_.doubt(who->line, id, true);
  }
}

/// Once a second.
void MqttEcology::look() {
  look_ = scheduler_.after(kLook, [this] { look(); });
  const auto now = scheduler_.now();
  std::erase_if(heard_, [now](const auto& one) { return now - one.second > kLately; });
  std::erase_if(questions_, [now](const auto& one) { return now - one.second.since > kLately; });
  const auto changes = std::exchange(shown_lately_, 0);
  if (!search_.ready()) return;
  if (now - shown_at_ > kShowAgain) show_all();
  const auto read = now - read_at_;
  if (read > read_again_in_ || (changes > kManyChanges && read > kSeldom)) read_again();
  ask_rivals();
  empty_leftovers();
  const auto alive = lifetime_.watch();
  look_at_suspects();
  if (!alive.ended()) ask_doubted();
}

void MqttEcology::read_again() {
  if (!search_.idle()) return;
  read_at_ = scheduler_.now();
  presence_.begin_reading();
  search_.read_again();
}

/// A component of this process need not be asked.
bool MqttEcology::seeks(std::optional<OwnerId> id) {
  if (!id) {
    search_.all();
    return !search_.knows_all();
  }
  if (links_.find(*id) || presence_.reached(*id)) return false;
  search_.component(*id);
  return !search_.knows(*id);
}

void MqttEcology::ask_doubted() {
  if (links_.all().empty()) return;
  for (const auto& [id, who] : presence_.doubted()) ask(*links_.all().begin()->second, id, *who);
}

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

/// nullptr: nothing proves the user.
std::shared_ptr<const Member> MqttEcology::vouched_member(const std::string& user) const {
  return vouched_ || options_.trust_broker ? member_of(options_, user) : nullptr;
}

/// Whether the user may use the id. Without a judge and a realm every user may use every id.
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
  Documents::Callbacks calls;
  calls.subscribe = [this](const std::string& filter) { std::ignore = uplink_.line()->subscribe(filter, 0); };
  calls.publish = [this](std::string topic, std::string payload) {
    std::ignore = publish({std::move(topic), std::move(payload), true, 1, {}, {}, 0});
  };
  documents_ =
      std::make_unique<Documents>(topics_, uplink_.broker().user, *options_.realm, scheduler_, log_, std::move(calls));
}

/// A component that may no longer be here is lost; the others get their new rights.
void MqttEcology::judge_again() {
  presence_.review_all();
  links_.each([](MqttLink& link) { link.judge_again(); });
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
