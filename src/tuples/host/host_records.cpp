#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "tuples/distant/frame_codec.h"
#include "tuples/host/host_ecology.h"
#include "tuples/host/host_link.h"

namespace rubicon::tuples::host {

namespace {

std::size_t cost(const SubscriptionSpec& spec) {
  return sizeof spec + 64 + spec.pattern.key.size();
}

/// A user without a number in this user namespace could be anybody: user_namespaces(7), "overflow".
constexpr std::string_view kOverflowUser = "65534";

Member member_of(const transport::UserName& name) {
  if (name.number == kOverflowUser) return {"user:unmapped"};
  Member user{"user:" + name.user, {"user:" + name.number}};
  for (const auto& group : name.groups) user.roles.push_back("group:" + group);
  return user;
}

bool is_stand_in(const Process::Component& component) {
  return carrier_of(component.host) != model::kNoOwner;
}

/// Takes note of what is kept of the process.
Result<void> note_kept(Process& process, std::size_t less, std::size_t more) {
  process.bytes += more - less;
  if (process.bytes <= Process::kMaxBytes) return {};
  return fail(ErrorCode::kRefused,
              fmt::format("its subscriptions and summaries have more than {} bytes", Process::kMaxBytes));
}

}  // namespace

/// A record of a process that may have come from a newer or a hostile program. An error is why the process is refused.
void HostEcology::on_record(Process& process, const Record& record) {
  const auto alive = lifetime_.watch();
  heard(process);
  if (alive.ended() || process.ended) return;
  const bool is_hello = record.type == Record::Type::kHello;
  const auto taken = is_hello          ? on_hello(process, record)
                     : process.greeted ? take(process, record)
                                       : fail(ErrorCode::kRefused, "it does not say who it is");
  if (alive.ended() || process.ended || taken) return;
  refuse(process, taken.error().text);
}

Result<void> HostEcology::take(Process& process, const Record& record) {
  using Type = Record::Type;
  switch (record.type) {
    case Type::kUp: return on_up(process, record);
    case Type::kDown: return forget(process, record.id), Result<void>();
    case Type::kSummary: return on_summary(process, record);
    case Type::kInterest: return on_interest(process, record);
    case Type::kNoInterest: return on_no_interest(process, record), Result<void>();
    case Type::kFrame: return on_frame(process, record);
    case Type::kReady: process.ready = true; break;
    case Type::kAsk:  // bytes that wait are an answer, too
      if (process.connection.waiting() == 0) process.connection.send({Record::Type::kAnswer});
      break;
    case Type::kGoodbye: process.said_goodbye = true; break;
    default: break;
  }
  return {};
}

/// The process that connected says hello first. The other one answers when it has chosen this connection.
Result<void> HostEcology::on_hello(Process& process, const Record& hello) {
  const auto reject = [](const std::string& why) { return fail(ErrorCode::kRefused, why); };
  if (process.greeted) return reject("it says hello twice");
  if (hello.number != kProtocolVersion) {
    if (!process.introduced) process.connection.send({Record::Type::kHello, {}, {}, kProtocolVersion, token_});
    process.connection.flush();  // so that the other side can say it, too
    return reject(
        fmt::format("it has version {} of the protocol, this program version {}", hello.number, kProtocolVersion));
  }
  const std::string token(hello.text);
  if (!is_token(token)) return reject("it sends an invalid token");
  if (process.ours && !process.own && token != process.door.token) return reject("it is not the process of its socket");
  const auto door = process.own ? folder_->own_door() : folder_->door_of(token, process.connection.peer());
  if (!door && door.error().code == ErrorCode::kNotFound) return end(process), Result<void>();  // it has ended since
  if (!door) return fail(door.error());
  if (!process.ours && is_twice(process, token)) return end(process), Result<void>();
  know(process, *door);
  process.greeted = true;
  later_.erase(process.door);
  if (options_.judge && !process.own) return ask_name(process), Result<void>();
  if (!process.introduced) introduce(process);
  return {};
}

/// Reads nothing more from the process until the name of its user is known: rules that deny a name or a group would
/// not apply to it.
void HostEcology::ask_name(Process& process) {
  process.connection.hold();
  folder_->name_of(process.connection.peer(), lifetime_.guard([this, token = process.door.token](const auto& name) {
    const auto [first, last] = known_.by_token.equal_range(token);
    const auto found = std::find_if(first, last, [](const auto& one) { return one.second->connection.is_held(); });
    if (found != last) take_name(*found->second, name);
  }));
}

void HostEcology::take_name(Process& process, const Result<transport::UserName>& name) {
  if (!name) return refuse(process, name.error().text);
  process.user = member_of(*name);
  if (!process.introduced) introduce(process);
  process.connection.release();
}

/// Two processes that start at the same time connect to each other: the connection of the higher token stays.
bool HostEcology::is_twice(const Process& process, const std::string& token) {
  std::vector<Process*> others;
  const auto [first, last] = known_.by_token.equal_range(token);
  std::for_each(first, last, [&](const auto& one) { others.push_back(one.second); });
  for (auto* other : others) {
    if (other == &process) continue;
    if (other->greeted || token_ > token) return true;
    end(*other);
  }
  return token == token_;
}

Result<void> HostEcology::on_up(Process& process, const Record& up) {
  forget(process, up.id);
  if (process.components.size() >= Process::kMaxComponents)
    return fail(ErrorCode::kRefused, fmt::format("it has more than {} components", Process::kMaxComponents));
  if (up.content.size() > kMaxSummary) return fail(ErrorCode::kRefused, "its summary is too long");
  if (number(up.id) < kFirstFreeId && !process.door.islands)
    return fail(ErrorCode::kRefused,
                fmt::format("it says that it is island {}, but here islands run only as the service", number(up.id)));
  process.components[up.id] = {up.number, std::string(up.text), std::string(base::as_text(up.content)), {}};
  known_.by_component[up.id].push_back(&process);
  const auto fits = note_kept(process, 0, up.content.size());
  review(up.id, PeerEvent::kLost);
  return fits;
}

/// The component left.
void HostEcology::forget(Process& process, OwnerId id) {
  const auto node = process.components.extract(id);
  if (!node) return;
  known_.unlist(process, id);
  std::size_t bytes = node.mapped().summary.size();
  for (const auto& [number, spec] : node.mapped().interests) bytes += cost(spec);
  std::ignore = note_kept(process, bytes, 0);
  review(id, PeerEvent::kLeft);
}

Process::Component* HostEcology::component(Process& process, OwnerId id) {
  const auto found = process.components.find(id);
  return found == process.components.end() ? nullptr : &found->second;
}

/// Whether the component of that id is the one of this process.
bool HostEcology::is_present(const Process& process, OwnerId id) const {
  const auto* known = present(id);
  return known && known->at == &process;
}

Result<void> HostEcology::on_summary(Process& process, const Record& news) {
  auto* of = component(process, news.id);
  if (!of) return {};
  if (news.content.size() > kMaxSummary) return fail(ErrorCode::kRefused, "its summary is too long");
  const auto fits = note_kept(process, of->summary.size(), news.content.size());
  const std::string summary(base::as_text(news.content));
  of->summary = summary;
  if (is_present(process, news.id)) each_listener(news.id, [&](LinkListener& to) { to.on_summary(news.id, summary); });
  return fits;
}

Result<void> HostEcology::on_interest(Process& process, const Record& news) {
  const auto spec = distant::read_subscription(news.content);
  if (!spec) return fail(spec.error());
  auto* of = component(process, news.id);
  if (!of) return {};
  auto& all = of->interests;
  const auto before = all.find(spec->id);
  if (before == all.end() && all.size() >= Process::kMaxInterests)
    return fail(ErrorCode::kRefused,
                fmt::format("component {} has more than {} subscriptions", number(news.id), Process::kMaxInterests));
  const auto fits = note_kept(process, before == all.end() ? 0 : cost(before->second), cost(*spec));
  all.insert_or_assign(spec->id, *spec);
  if (is_present(process, news.id)) each_listener(news.id, [&](LinkListener& to) { to.on_subscribe(news.id, *spec); });
  return fits;
}

void HostEcology::on_no_interest(Process& process, const Record& news) {
  auto* of = component(process, news.id);
  const auto id = static_cast<std::uint32_t>(news.number);
  const auto found = of ? of->interests.find(id) : std::map<std::uint32_t, SubscriptionSpec>::iterator();
  if (!of || found == of->interests.end()) return;
  std::ignore = note_kept(process, cost(found->second), 0);
  of->interests.erase(found);
  if (is_present(process, news.id)) each_listener(news.id, [&](LinkListener& to) { to.on_unsubscribe(news.id, id); });
}

/// Drops messages to an earlier start of the own component, and messages from a component that does not count.
Result<void> HostEcology::on_frame(Process& process, const Record& frame) {
  if (!component(process, frame.id))
    return fail(ErrorCode::kRefused, fmt::format("it has no component {}", number(frame.id)));
  auto* link = links_.find(frame.target);
  if (!link || link->incarnation() != frame.number || !is_present(process, frame.id)) return {};
  return link->deliver(frame.id, frame.content);
}

const HostEcology::Present* HostEcology::present(OwnerId id) const {
  const auto found = present_.find(id);
  return found == present_.end() ? nullptr : &found->second;
}

/// Chooses among components with one id: the component itself before a stand-in, then one of this process, then the one
/// that is known already. The starts that they declare decide only between components that come at the same time: none
/// takes an id from another.
Process* HostEcology::best(OwnerId id) const {
  Process* found = nullptr;
  const auto* known = present(id);
  const auto rank = [id, known](const Process& one) {
    const auto& component = one.components.at(id);
    return std::tuple(is_stand_in(component), !one.own, !known || known->at != &one, component.incarnation);
  };
  const auto having = known_.by_component.find(id);
  if (having == known_.by_component.end()) return nullptr;
  for (auto* one : having->second) {
    if (one->ended || one->silent) continue;
    if (!found || rank(*one) < rank(*found)) found = one;
  }
  return found;
}

PeerIdentity HostEcology::identity(const Process& process, OwnerId id) const {
  const auto& component = process.components.at(id);
  PeerIdentity who{id, component.incarnation, component.host, nullptr, process.own, true};
  if (!options_.judge || process.own) return who;
  auto member = process.user;
  member.ids = {{number(id), number(id)}};
  who.member = std::make_shared<const Member>(std::move(member));
  return who;
}

/// Reports to the own components what changed of that id.
void HostEcology::review(OwnerId id, PeerEvent how) {
  auto* now = best(id);
  const auto* known = present(id);
  const auto start = now ? now->components.at(id).incarnation : 0;
  if (known && known->at == now && known->who.incarnation == start) return;
  const auto alive = lifetime_.watch();
  if (known) {
    const auto who = known->who;
    present_.erase(id);
    links_.each([&](HostLink& link) { link.peer_down(who, how); });
    if (alive.ended()) return;
    now = best(id);  // a call may have changed it
  }
  if (!now) return;
  const Present news{now, identity(*now, id)};
  present_[id] = news;
  if (auto* link = links_.find(id); link && link->attached() && !now->own) link->displace();
  links_.each([&](HostLink& link) { link.peer_up(news); });
}

void HostEcology::review_all(const Process& process, PeerEvent how) {
  std::vector<OwnerId> ids;
  for (const auto& [id, component] : process.components) ids.push_back(id);
  const auto alive = lifetime_.watch();
  for (const auto id : ids) {
    if (alive.ended()) return;
    review(id, how);
  }
}

}  // namespace rubicon::tuples::host
