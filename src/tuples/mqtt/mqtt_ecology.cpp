#include "tuples/mqtt/mqtt_ecology.h"

#include <fmt/format.h>

#include <algorithm>
#include <random>

#include "transport/host_name.h"
#include "tuples/mqtt/mqtt_link.h"

namespace rubicon::tuples::mqtt {

namespace {

constexpr Duration kFirstPause = std::chrono::milliseconds(500), kLongestPause = std::chrono::seconds(10);
/// A wrong password does not become right by repetition.
constexpr Duration kRefusedPause = std::chrono::seconds(30);
/// A message to oneself comes back within this time.
constexpr Duration kFenceTime = std::chrono::seconds(10);
constexpr unsigned kShards = 16;
/// First byte of a message to oneself; frames begin with the version.
constexpr std::uint8_t kFence = 0xff;
/// A broker looks each 5 s whom it did not hear for one and a half keep-alive times (mosquitto 2.0).
constexpr Duration kBrokerLooks = std::chrono::seconds(5);
/// Frames that all others together may have under way to one process: below the queue that brokers have by default.
constexpr std::uint32_t kQueue = 800, kLeastCredit = 4;
/// A broker forgets what is retained after this time; it is written again before.
constexpr Duration kRetained = std::chrono::hours(1), kShowAgain = std::chrono::minutes(25);
/// Connections whose topics are emptied; what others left ends by itself.
constexpr std::size_t kMaxFormer = 16;
constexpr Duration kLately = std::chrono::seconds(10);
constexpr Duration kLook = std::chrono::seconds(1);

std::string random_token() {
  static constexpr std::string_view kDigits = "0123456789abcdef";
  std::random_device source;
  std::string token;
  for (int i = 0; i < 12; ++i) token += kDigits[source() % kDigits.size()];
  return token;
}

}  // namespace

MqttEcology::MqttEcology(SpaceOptions options, Scheduler& scheduler, transport::Transports& transports,
                         base::LogSink& log, Clock since_boot)
    : options_(std::move(options)),
      scheduler_(scheduler),
      transports_(transports),
      log_(Log(log, "mqtt"), scheduler),
      since_boot_(std::move(since_boot)),
      topics_(options_.space),
      presence_(scheduler, {[this](OwnerId id, PeerEvent how) { on_changed(id, how); }}),
      streams_(static_cast<std::uint64_t>(since_boot_() / std::chrono::microseconds(1))),
      pause_(kFirstPause),
      flush_soon_(scheduler, [this] { each_link([](MqttLink& link) { link.flush(); }); }) {}

Result<void> check_options(const SpaceOptions& options) {
  if (auto good = options.user == kAnonymous ? Result<void>() : check_user(options.user); !good) return good;
  if (!is_space(options.space))
    return fail(ErrorCode::kInvalid,
                fmt::format("'{}' is no space, expected 1 to 64 letters, digits, _ . -", options.space));
  if (options.lease >= kMinLease) return {};
  return fail(ErrorCode::kInvalid,
              fmt::format("a lease of {} s is too short for a broker, expected at least {} s",
                          options.lease / std::chrono::seconds(1), kMinLease / std::chrono::seconds(1)));
}

Result<std::unique_ptr<MqttEcology>> MqttEcology::open(SpaceOptions options, Scheduler& scheduler,
                                                       transport::Transports& transports, base::LogSink& log,
                                                       Clock since_boot) {
  if (auto good = check_options(options); !good) return fail(std::move(good.error()));
  std::unique_ptr<MqttEcology> ecology(
      new MqttEcology(std::move(options), scheduler, transports, log, std::move(since_boot)));
  if (auto begun = ecology->connect(); !begun) return fail(std::move(begun.error()));
  ecology->look();
  return ecology;
}

MqttEcology::~MqttEcology() {
  if (connected_) publish(topics_.line(own_), {}, true);
}

// -- the connection

Result<void> MqttEcology::connect() {
  own_ = {options_.user, random_token()};
  auto options = options_.broker;
  options.keep_alive = (options_.lease - kBrokerLooks) * 2 / 3;
  options.will = transport::MqttWill{topics_.line(own_), {}, true, 1};
  auto opened = transports_.open_mqtt(options, line_calls());
  if (!opened) return fail(std::move(opened.error()));
  line_ = std::move(*opened);
  return {};
}

transport::MqttCalls MqttEcology::line_calls() {
  transport::MqttCalls calls;
  calls.connected = [this](const transport::MqttConnack& connack) { on_connected(connack); };
  calls.received = [this](const transport::MqttMessage& message) { on_message(message); };
  calls.too_long = [this](std::string_view topic, std::size_t bytes) {
    log_.warning("too long", fmt::format("a message of {} bytes at {} is dropped", bytes, topic));
  };
  calls.subscribed = [](std::string_view) {};
  calls.refused = [this](std::string_view filter, const Error& why) {
    log_.warning("refused", fmt::format("the broker refuses {}: {}", filter, why.text));
  };
  calls.taken = [](const transport::MqttOutcome&) {};
  calls.not_taken = [this](const transport::MqttOutcome& outcome, const Error& why) {
    log_.warning("not taken", fmt::format("the broker does not take {}: {}", outcome.topic, why.text));
  };
  calls.failed = [this](const Error& why) { on_failed(why); };
  return calls;
}

/// The own inbox first; then presence, one part after the other: the end of each is a message to oneself, which follows
/// all that is retained.
void MqttEcology::on_connected(const transport::MqttConnack& connack) {
  if (!connack.retains)
    return on_failed({ErrorCode::kRefused, "the broker keeps no retained messages, which presence needs"});
  if (count_++ > 0) ++counters_.reconnects;
  connected_ = true;
  knows_all_ = false;
  fences_ = 0;
  pause_ = kFirstPause;
  trouble_.clear();
  log_.unlimited().info(fmt::format("connected with {}:{} as {}", options_.broker.host, options_.broker.port,
                                    options_.user == kAnonymous ? "nobody" : options_.user));
  std::ignore = line_->subscribe(topics_.inbox_filter(own_), 0);
  show_all();
  fence();
}

void MqttEcology::on_failed(const Error& why) {
  const bool refused = why.code == ErrorCode::kRefused;
  if (connected_ && former_.size() < kMaxFormer) former_.push_back(own_);
  connected_ = false;
  fence_timer_.cancel();
  line_.reset();
  trouble_ = why.text;
  log_.warning("connection", fmt::format("{}:{}: {}", options_.broker.host, options_.broker.port, why.text));
  presence_.cut();
  if (refused) pause_ = kRefusedPause;
  connect_later();
}

void MqttEcology::connect_later() {
  retry_ = scheduler_.after(pause_, [this] {
    if (auto begun = connect(); !begun) {
      trouble_ = begun.error().text;
      log_.warning("connection", begun.error().text);
      connect_later();
    }
  });
  pause_ = std::min(2 * pause_, std::max(pause_, kLongestPause));
}

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

void MqttEcology::fence() {
  publish(topics_.inbox(own_, own_), {static_cast<char>(kFence), static_cast<char>(fences_)}, false);
  fence_timer_ = scheduler_.after(kFenceTime, [this] {
    log_.warning("fence", fmt::format("the broker does not hand on what {} sends to itself: it takes and drops, or its "
                                      "rights lack this user's inbox ({})",
                                      options_.user, topics_.inbox_filter(own_)));
    fence();  // it may have been dropped
  });
}

void MqttEcology::on_fence(ByteView payload) {
  if (payload.size() != 2 || payload[1] != fences_) return;
  fence_timer_.cancel();
  if (++fences_ > kShards) return on_complete();
  std::ignore = line_->subscribe(topics_.presence_filter("0123456789abcdef"[fences_ - 1]), 0);
  fence();
}

void MqttEcology::on_complete() {
  knows_all_ = true;
  empty_former();
  presence_.read_again();
  each_link([](MqttLink& link) { link.reconnected(); });
}

bool MqttEcology::publish(std::string topic, std::string payload, bool retained) {
  if (!connected_) return false;
  transport::MqttPublication one{std::move(topic), std::move(payload), retained, 0, {}, {}, 0};
  if (retained) {
    one.qos = 1;  // the answer counts
    one.expiry = kRetained;
  }
  auto done = line_->publish(std::move(one));
  if (!done && done.error().code != ErrorCode::kBusy) log_.warning("publish", done.error().text);
  return done.has_value();
}

// -- what arrives

void MqttEcology::on_message(const transport::MqttMessage& message) {
  const auto at = topics_.parse(message.topic);
  if (const auto* inbox = std::get_if<Topics::Inbox>(&at)) {
    if (message.retained || inbox->to != own_) return foreign(inbox->from, "a retained message");
    const auto payload = base::as_bytes(message.payload);
    if (inbox->from == own_ && !payload.empty() && payload[0] == kFence) return on_fence(payload);
    return on_frame(inbox->from, payload);
  }
  if (const auto* presence = std::get_if<Topics::Presence>(&at))
    return on_presence(*presence, message.payload, message.retained);
  ++counters_.foreign;
  log_.warning("foreign", fmt::format("a message at {}, which is no topic of ours", message.topic));
}

void MqttEcology::foreign(const Line& from, const std::string& what) {
  ++counters_.foreign;
  log_.warning("foreign " + from.user, fmt::format("{} of user {}: dropped", what, from.user));
}

void MqttEcology::on_presence(const Topics::Presence& at, std::string_view payload, bool) {
  if (payload.empty()) return at.component ? presence_.hide(at.line, *at.component, false) : presence_.hide(at.line);
  if (payload == kLeft && at.component) return presence_.hide(at.line, *at.component, true);
  if (payload.size() > kMaxPresence) return foreign(at.line, fmt::format("presence of {} bytes", payload.size()));
  bool room = true;
  if (at.component && !may_have(at.line, *at.component))
    return foreign(at.line, fmt::format("presence of component {}, an id of another user,", number(*at.component)));
  if (at.component) {
    auto shown = read_component(payload);
    if (!shown) return foreign(at.line, shown.error().text);
    room = presence_.show(at.line, *at.component, std::move(*shown));
  } else {
    const auto shown = read_line(payload);
    if (!shown) return foreign(at.line, shown.error().text);
    room = presence_.show(at.line, *shown);
  }
  if (!room) log_.warning("presence", "too many components are in this space: some are ignored");
}

void MqttEcology::on_frame(const Line& from, ByteView payload) {
  ByteView entries;
  const auto head = read_head(payload, entries);
  if (!head) return foreign(from, head.error().text);
  if (is_own(head->source, head->source_incarnation))
    return foreign(from, fmt::format("a frame in the name of component {} of this process", number(head->source)));
  take(from, *head, entries);
}

bool MqttEcology::is_own(OwnerId id, std::uint64_t incarnation) const {
  const auto* link = find_link(id);
  return link && link->attached() && link->incarnation() == incarnation;
}

/// Where somebody vouches for users.
bool MqttEcology::may_have(const Line& line, OwnerId id) const {
  if (!options_.judge && !options_.member_of) return true;
  const auto member = member_of(options_, line.user);
  return member && member->may_use(id);
}

/// From the line of the component that counts, and for the present start of an own one.
void MqttEcology::take(const Line& from, const FrameHead& head, ByteView entries) {
  auto* link = find_link(head.target);
  if (!link || !link->attached() || link->incarnation() != head.target_incarnation) return;
  if (head.number == 0 && !entries.empty()) return on_check(from, head, entries);
  const auto* source = presence_.reached(head.source);
  const bool known = source && source->shown.incarnation == head.source_incarnation;
  if (!known) return hold(from, head, entries);
  if (source->line.user != from.user)
    return foreign(from, fmt::format("a frame in the name of component {}", number(head.source)));
  heard_[head.source] = scheduler_.now();
  link->arrived(head, entries);
}

/// Its presence may be under way: it is kept a moment, else its sender sends it again.
void MqttEcology::hold(const Line& from, const FrameHead& head, ByteView entries) {
  const auto now = scheduler_.now();
  while (!early_.empty() && now - early_.front().since > kLately) {
    early_bytes_ -= early_.front().entries.size() + sizeof(Early);
    early_.pop_front();
  }
  if (early_bytes_ + entries.size() + sizeof(Early) > kMaxEarly) return;
  early_bytes_ += entries.size() + sizeof(Early);
  early_.push_back({from, head, Bytes(entries.begin(), entries.end()), now});
}

void MqttEcology::on_changed(OwnerId id, PeerEvent how) {
  const auto alive = lifetime_.watch();
  each_link([&](MqttLink& link) { link.review(id, how); });
  if (alive.ended() || !presence_.reached(id)) return;
  std::deque<Early> due;
  for (auto one = early_.begin(); one != early_.end();) {
    if (one->head.source != id) {
      ++one;
      continue;
    }
    early_bytes_ -= one->entries.size() + sizeof(Early);
    due.push_back(std::move(*one));
    one = early_.erase(one);
  }
  for (const auto& one : due) {
    if (!alive.ended()) take(one.from, one.head, one.entries);
  }
}

// -- who has an id, and who answers

namespace {

struct Check final : distant::FrameReader {
  void on_changes(std::span<const Change>) override {}
  void on_set(RemoteSet&&) override {}
  void on_reply(Reply&&) override {}
  void on_times(const distant::FrameTimes&) override {}
  void on_identity_check(const distant::IdentityCheck& check) override { found = check; }
  std::optional<distant::IdentityCheck> found;
};

}  // namespace

/// Whether a component lives.
void MqttEcology::ask(const MqttLink& asker, OwnerId id, const Reached& who) {
  distant::FrameWriter entry;
  entry.add(distant::IdentityCheck{false, question_});
  FrameHead head;
  head.source = asker.id();
  head.source_incarnation = asker.incarnation();
  head.target = id;
  head.target_incarnation = who.shown.incarnation;
  send_to(who.line, head, entry.view());
}

/// A question is answered by whoever lives. The answer of an earlier start of an own component displaces that.
void MqttEcology::on_check(const Line& from, const FrameHead& head, ByteView entries) {
  Check check;
  if (!distant::read_frame(entries, head.source, head.target, check) || !check.found) return;
  if (!check.found->is_answer) {
    distant::FrameWriter answer;
    answer.add(distant::IdentityCheck{true, check.found->number});
    FrameHead back;
    back.source = head.target;
    back.source_incarnation = head.target_incarnation;
    back.target = head.source;
    back.target_incarnation = head.source_incarnation;
    return void(send_to(from, back, answer.view()));
  }
  if (check.found->number != question_) return;
  presence_.believe(from);
  if (head.source != head.target || head.source_incarnation >= head.target_incarnation) return;
  if (auto* link = find_link(head.target)) link->displace();
}

/// Another component with the id of an own one that began before it.
void MqttEcology::ask_rivals() {
  each_link([this](const MqttLink& link) {
    for (const auto& other : presence_.all_with(link.id())) {
      if (other.line.token != own_.token && other.shown.incarnation < link.incarnation()) ask(link, link.id(), other);
    }
  });
}

/// Once a second.
void MqttEcology::look() {
  look_ = scheduler_.after(kLook, [this] { look(); });
  if (question_ == 0) question_ = static_cast<std::uint64_t>(std::random_device()()) << 16 | 1;
  std::erase_if(heard_, [now = scheduler_.now()](const auto& one) { return now - one.second > kLately; });
  if (!knows_all_ || !connected_) return;
  if (scheduler_.now() - shown_at_ > kShowAgain) show_all();
  ask_rivals();
  const auto alive = lifetime_.watch();
  each_link([this](const MqttLink& link) {
    for (const auto id : link.silent(options_.lease)) {
      if (const auto* silent = presence_.reached(id)) presence_.doubt(Line(silent->line));
    }
  });
  if (!alive.ended()) ask_doubted();
}

void MqttEcology::ask_doubted() {
  if (links_.empty()) return;
  for (const auto& [id, who] : presence_.doubted()) ask(*links_.begin()->second, id, who);
}

// -- for links

bool MqttEcology::send(const FrameHead& head, ByteView entries) {
  if (is_own(head.target, head.target_incarnation)) {
    lifetime_.post(scheduler_, [this, head, kept = Bytes(entries.begin(), entries.end())] { take(own_, head, kept); });
    return true;
  }
  const auto* target = presence_.reached(head.target);
  return target && send_to(target->line, head, entries);
}

bool MqttEcology::send_to(const Line& to, const FrameHead& head, ByteView entries) {
  const auto frame = frame_of(head, entries);
  return publish(topics_.inbox(to, own_), std::string(base::as_text(frame)), false);
}

void MqttEcology::show(const MqttLink& link) {
  const bool shown = publish(topics_.component(own_, link.id()), component_text(link.shown()), true);
  if (!shown) shown_at_ = scheduler_.now() - 2 * kShowAgain;  // all of it again soon
}

/// First that it leaves, so that nobody takes it for lost.
void MqttEcology::hide(const MqttLink& link) {
  const auto topic = topics_.component(own_, link.id());
  publish(topic, std::string(kLeft), false);
  publish(topic, {}, true);
}

std::uint32_t MqttEcology::credit() const {
  const auto senders = std::max<std::size_t>(heard_.size(), 1);
  return std::clamp(static_cast<std::uint32_t>(kQueue / senders), kLeastCredit, Channel::kMaxCredit);
}

/// A call may end links.
void MqttEcology::each_link(const std::function<void(MqttLink& link)>& call) {
  std::vector<OwnerId> ids;
  for (const auto& [id, link] : links_) ids.push_back(id);
  const auto alive = lifetime_.watch();
  for (const auto id : ids) {
    auto* link = alive.ended() ? nullptr : find_link(id);
    if (link && link->attached()) call(*link);
  }
}

MqttLink* MqttEcology::find_link(OwnerId id) const {
  const auto found = links_.find(id);
  return found == links_.end() ? nullptr : found->second;
}

Result<std::unique_ptr<Link>> MqttEcology::join(OwnerId id) {
  return join_as({id, transport::host_id("host"), [this, id] {
                    if (displaced_) displaced_(id);
                  }});
}

Result<std::unique_ptr<Link>> MqttEcology::join_as(StandIn who) {
  if (find_link(who.id))
    return fail(ErrorCode::kDuplicate, fmt::format("component {} is already present in this process", number(who.id)));
  return std::make_unique<MqttLink>(*this, std::move(who));
}

}  // namespace rubicon::tuples::mqtt
