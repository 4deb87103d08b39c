#include <fmt/format.h>

#include <random>

#include "tuples/mqtt/mqtt_ecology.h"
#include "tuples/mqtt/mqtt_link.h"

namespace rubicon::tuples::mqtt {

namespace {

/// What is retained is written again before brokers forget it.
constexpr Duration kShowAgain = std::chrono::minutes(25);
constexpr Duration kLook = std::chrono::seconds(1);
/// After so many changes in one look some may have been dropped: presence is read again.
constexpr unsigned kManyChanges = 500;
constexpr Duration kSeldom = std::chrono::seconds(30);
/// Of the own user: connections that are looked at, and components of each; how long nothing may be heard of one.
constexpr std::size_t kMaxOwnLines = 256, kMaxOwnIds = 256;
constexpr Duration kLeftFor = std::chrono::seconds(60);
/// Of a component that lives.
constexpr Duration kAnswerWithin = std::chrono::seconds(3);

std::uint64_t random_number() {
  std::random_device source;
  return static_cast<std::uint64_t>(source()) << 31 | source();
}

struct Check final : distant::FrameReader {
  void on_changes(std::span<const Change>) override {}
  void on_set(RemoteSet&&) override {}
  void on_reply(Reply&&) override {}
  void on_times(const distant::FrameTimes&) override {}
  void on_identity_check(const distant::IdentityCheck& check) override { found = check; }
  std::optional<distant::IdentityCheck> found;
};

}  // namespace

// -- what this process shows

void MqttEcology::show_all() {
  shown_at_ = scheduler_.now();
  publish(topics_.line(own_), line_text({count_, options_.lease}), true);
  each_link([this](const MqttLink& link) { show(link); });
}

/// What earlier connections of this process showed; the broker's own message for their end may come later.
void MqttEcology::empty_former() {
  for (const auto& line : std::exchange(former_, {})) {
    for (const auto id : presence_.shown_on(line)) publish(topics_.component(line, id), {}, true);
    publish(topics_.line(line), {}, true);
  }
}

void MqttEcology::show(const MqttLink& link) {
  if (!publish(topics_.component(own_, link.id()), component_text(link.shown()), true)) show_soon();
}

void MqttEcology::show_soon() {
  shown_at_ = scheduler_.now() - 2 * kShowAgain;
}

/// First that it leaves, so that nobody takes it for lost.
void MqttEcology::hide(const MqttLink& link) {
  const auto topic = topics_.component(own_, link.id());
  publish(topic, std::string(kLeft), false);
  publish(topic, {}, true);
}

/// In order: nothing of it stays at this broker.
void MqttEcology::leave() {
  each_link([this](const MqttLink& link) { publish(topics_.component(own_, link.id()), {}, true); });
  publish(topics_.line(own_), {}, true);
}

/// Brokers of version 3.1.1 keep what a killed process showed: its user empties it.
void MqttEcology::note_own(const Topics::Presence& at, std::uint64_t incarnation, bool here) {
  if (at.line == own_) {  // another one of this user took it for dead
    const auto* link = at.component ? find_link(*at.component) : nullptr;
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

/// A connection that is there answers for a component of it. One that has none shows little, and nobody can ask it.
void MqttEcology::empty_leftovers() {
  for (auto next = own_lines_.begin(); next != own_lines_.end();) {
    const auto now = next++;
    const auto& [line, one] = *now;
    if (one.here && (one.heard || one.ids.empty() || links_.empty())) continue;
    if (scheduler_.now() - one.since < kLeftFor) {
      const auto& [id, incarnation] = *one.ids.begin();
      const auto* asker = find_link(id);
      if (one.here) ask(asker ? *asker : *links_.begin()->second, id, {line, {incarnation, {}, {}}});
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

/// A question is answered by whoever lives.
void MqttEcology::on_check(const Line& from, const FrameHead& head, ByteView entries) {
  Check check;
  if (!distant::read_frame(entries, head.source, head.target, check) || !check.found) return;
  if (check.found->is_answer) return on_answer(from, head, check.found->number);
  // A stand-in gives way: it ends no component.
  if (const auto* asked = find_link(head.target); head.source == head.target && asked && asked->is_stand_in()) return;
  distant::FrameWriter answer;
  answer.add(distant::IdentityCheck{true, check.found->number});
  FrameHead back;
  back.source = head.target;
  back.source_incarnation = head.target_incarnation;
  back.target = head.source;
  back.target_incarnation = head.source_incarnation;
  send_to(from, back, answer.view());
}

/// Of the start that was asked, from where it was asked. That of an earlier start of an own component displaces that.
void MqttEcology::on_answer(const Line& from, const FrameHead& head, std::uint64_t number) {
  const auto question = questions_.extract({head.source, from});
  if (question.empty() || question.mapped().number != number ||
      question.mapped().incarnation != head.source_incarnation || question.mapped().asker != head.target)
    return;
  if (const auto suspect = suspects_.find(head.source); suspect != suspects_.end())
    suspect->second = {SteadyTime::max(), scheduler_.now()};
  presence_.believe(from, head.source);
  if (head.source != head.target || head.source_incarnation >= head.target_incarnation) return;
  if (auto* link = find_link(head.target)) link->displace();
}

/// Another component with the id of an own one that began before it. One of another user ends nobody.
void MqttEcology::ask_rivals() {
  each_link([this](const MqttLink& link) {
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

/// Those that do not acknowledge are asked; who does not answer either is gone.
void MqttEcology::look_at_silent() {
  const auto now = scheduler_.now();
  std::map<OwnerId, Suspect> silent;
  std::vector<std::pair<OwnerId, const MqttLink*>> unasked;
  std::vector<OwnerId> over;
  each_link([&](const MqttLink& link) {
    for (const auto id : link.silent(options_.lease - kAnswerWithin)) {
      const auto known = suspects_.find(id);
      auto suspect = known == suspects_.end() ? Suspect() : known->second;
      const bool asked = suspect.asked != SteadyTime::max();
      if (asked && now - suspect.asked >= kAnswerWithin) over.push_back(id);
      if (!asked && now - suspect.answered >= options_.lease - kAnswerWithin) {
        suspect.asked = now;
        unasked.emplace_back(id, &link);
      }
      silent.insert_or_assign(id, suspect);
    }
  });
  suspects_ = std::move(silent);
  for (const auto& [id, link] : unasked) {
    if (const auto who = presence_.reached(id)) ask(*link, id, *who);
  }
  const auto alive = lifetime_.watch();
  for (const auto id : over) {
    if (const auto who = alive.ended() ? nullptr : presence_.reached(id)) presence_.doubt(who->line, id);
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
  look_at_silent();
  if (!alive.ended()) ask_doubted();
}

void MqttEcology::read_again() {
  if (!search_.idle()) return;
  read_at_ = scheduler_.now();
  presence_.begin_reading();
  search_.read_again();
}

/// For a component of this process nobody has to be asked.
bool MqttEcology::seeks(std::optional<OwnerId> id) {
  if (!id) {
    search_.all();
    return !search_.knows_all();
  }
  if (find_link(*id) || presence_.reached(*id)) return false;
  search_.component(*id);
  return !search_.knows(*id);
}

void MqttEcology::ask_doubted() {
  if (links_.empty()) return;
  for (const auto& [id, who] : presence_.doubted()) ask(*links_.begin()->second, id, *who);
}

}  // namespace rubicon::tuples::mqtt
