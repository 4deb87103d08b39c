#include "tuples/mqtt/mqtt_ecology.h"

#include <fmt/format.h>

#include <algorithm>
#include <random>

#include "base/text.h"
#include "transport/host_names.h"
#include "tuples/mqtt/mqtt_link.h"
#include "tuples/refusals.h"

namespace rubicon::tuples::mqtt {

namespace {

/// First byte of a message to oneself; frames begin with the version.
constexpr std::uint8_t kFence = 0xff;
/// A broker checks every 5 s which clients were silent for one and a half keep-alive times (mosquitto 2.0).
constexpr Duration kBrokerLooks = std::chrono::seconds(5);
/// libmosquitto's.
constexpr Duration kMinKeepAlive = std::chrono::seconds(5);
/// Frames that all others together may have under way to one process: below the queue that brokers have by default.
constexpr std::uint32_t kQueue = 800, kMinCredit = 1;
/// A broker forgets what is retained after this time.
constexpr Duration kRetained = std::chrono::hours(1);
/// Connections whose topics are emptied; what others left ends by itself.
constexpr std::size_t kMaxFormer = 16;
/// Topic and head of a frame, at most, in bytes.
constexpr std::size_t kMaxHead = 600;
/// Frames whose size a broker has to judge.
constexpr std::size_t kMaxLarge = 64;
/// Brokers forget what expires without a word, and drop what exceeds their queue: presence is read again from time to
/// time.
constexpr Duration kReadAgain = std::chrono::minutes(15);

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
      log_(Log(log, "mqtt"), scheduler),
      since_boot_(std::move(since_boot)),
      topics_(options_.space),
      presence_(scheduler, {[this](OwnerId id, PeerEvent how) { on_changed(id, how); },
                            [this](const Line& line) { search_.forget(line); },
                            [this](const Line& line, OwnerId id) {
                              return line == own_ || presence_.is_here(line) || may_have(line.user, id);
                            }}),
      search_(topics_, scheduler, search_calls()),
      uplink_(options_.brokers, std::max(kMinKeepAlive, (options_.lease - kBrokerLooks - Presence::kReturn) * 2 / 3),
              scheduler, transports, log_, uplink_calls()),
      streams_(static_cast<std::uint64_t>(since_boot_() / std::chrono::microseconds(1))),
      flush_soon_(scheduler, [this] { links_.each([](MqttLink& link) { link.flush(); }); }),
      show_here_soon_(scheduler, [this] {
        std::map<OwnerId, ComponentShown> here;
        links_.each([&](const MqttLink& link) { here[link.id()] = link.shown(); });
        presence_.show_here({own_.user, random_token()}, options_.lease, here);
      }) {}

Result<void> check_options(const SpaceOptions& options) {
  if (options.brokers.empty()) return fail(ErrorCode::kInvalid, "no broker");
  for (const auto& broker : options.brokers) {
    if (auto good = broker.user == kAnonymous ? Result<void>() : check_user(broker.user); !good) return good;
  }
  if (!is_space(options.space))
    return fail(ErrorCode::kInvalid,
                fmt::format("'{}' is not a space, expected 1 to 64 letters, digits, _ . -", options.space));
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
  if (ecology->options_.realm) ecology->open_documents();
  if (auto begun = ecology->uplink_.open(); !begun) return fail(std::move(begun.error()));
  if (ecology->options_.watch_all) ecology->search_.all();
  ecology->look();
  return ecology;
}

MqttEcology::~MqttEcology() {
  publish(topics_.line(own_), {}, true);
}

// -- the connection

Uplink::Callbacks MqttEcology::uplink_calls() {
  Uplink::Callbacks calls;
  calls.begins = [this](const std::string& user) {
    own_ = {user, random_token()};
    show_here_soon_.request();
    return transport::MqttWill{topics_.line(own_), {}, true, 1};
  };
  calls.connected = [this](const transport::MqttConnack& connack) { on_connected(connack); };
  calls.received = [this](const transport::MqttMessage& message) { on_message(message); };
  calls.taken = [this](const transport::MqttOutcome& outcome) { on_taken(outcome); };
  calls.not_taken = [this](const transport::MqttOutcome& outcome, const Error& why) { on_not_taken(outcome, why); };
  // In order: no topic of this connection stays at the broker.
  calls.leaves = [this] {
    links_.each([this](const MqttLink& link) { publish(topics_.component(own_, link.id()), {}, true); });
    publish(topics_.line(own_), {}, true);
  };
  calls.lost = [this] { on_lost(); };
  return calls;
}

void MqttEcology::on_connected(const transport::MqttConnack& connack) {
  if (count_++ > 0) ++counters_.reconnects;
  returns_ = true;
  answers_ = connack.version == transport::MqttVersion::k5;
  largest_ = connack.largest_packet > kMaxHead ? connack.largest_packet - kMaxHead : SIZE_MAX;
  proven_ = 0;
  large_.clear();
  if (documents_) documents_->connected();  // who was shut out meanwhile, before messages of others
  std::ignore = uplink_.line()->subscribe(topics_.inbox_filter(own_), 0);
  if (!answers_ && own_.user != kAnonymous) std::ignore = uplink_.line()->subscribe(topics_.user_filter(own_.user), 0);
  probed_ = false;
  std::ignore = uplink_.line()->subscribe(topics_.presence_probe(own_), 0);
  publish(topics_.inbox_probe(own_), {}, false);
  publish(topics_.presence_probe(own_), {}, false);
  show_all();
  search_.connected();
}

void MqttEcology::on_lost() {
  if (former_.size() < kMaxFormer) former_.push_back(own_);
  own_lines_.clear();
  search_.cut();
  presence_.cut();
  if (documents_) documents_->cut();
}

Search::Callbacks MqttEcology::search_calls() {
  Search::Callbacks calls;
  calls.subscribe = [this](const std::string& filter) { std::ignore = uplink_.line()->subscribe(filter, 0); };
  calls.unsubscribe = [this](const std::string& filter) { std::ignore = uplink_.line()->unsubscribe(filter); };
  calls.fence = [this](std::uint64_t step) {
    publish(topics_.inbox(own_, own_), static_cast<char>(kFence) + std::to_string(step), false);
  };
  calls.late = [this] {
    log_.warning("fence", fmt::format("the broker does not deliver what {} sends to itself: it drops messages, or its "
                                      "rights do not let this user read its inbox ({})",
                                      own_.user, topics_.inbox_filter(own_)));
  };
  calls.line_read = [this](const Line& line) {
    presence_.has(line) ? presence_.end_reading(line) : search_.forget(line);
  };
  calls.complete = [this](bool all) { on_complete(all); };
  return calls;
}

/// The wanted presence was read, or was read again.
void MqttEcology::on_complete(bool all) {
  read_at_ = scheduler_.now();
  read_again_in_ = about(kReadAgain);
  const auto alive = lifetime_.watch();
  presence_.end_reading(all);
  if (alive.ended() || !std::exchange(returns_, false)) return;
  if (documents_) documents_->read();
  empty_former();
  links_.each([](MqttLink& link) { link.reconnected(); });
}

bool MqttEcology::publish(std::string topic, std::string payload, bool retained) {
  transport::MqttPublication one{std::move(topic), std::move(payload), retained, 0, {}, {}, 0};
  if (retained) {
    one.qos = 1;  // the answer counts
    one.expiry = kRetained;
  }
  return publish(std::move(one));
}

bool MqttEcology::publish(transport::MqttPublication one) {
  if (!uplink_.line()) return false;
  auto done = uplink_.line()->publish(std::move(one));
  if (!done && done.error().code != ErrorCode::kBusy) log_.warning("publish", done.error().text);
  return done.has_value();
}

// -- what arrives

void MqttEcology::on_message(const transport::MqttMessage& message) {
  if (documents_ && documents_->received(message.topic, message.payload)) return;
  const auto at = topics_.parse(message.topic);
  if (const auto* inbox = std::get_if<Topics::Inbox>(&at)) {
    if (message.retained || inbox->to != own_) return foreign(inbox->from, "a retained message");
    const auto payload = base::as_bytes(message.payload);
    if (inbox->from == own_ && !payload.empty() && payload[0] == kFence) {
      const auto step = base::parse_number<std::uint64_t>(base::as_text(payload.subspan(1)));
      if (!probed_) set_vouched(true);  // it was sent before and did not come
      return search_.passed(step.value_or(0));
    }
    return on_frame(inbox->from, payload);
  }
  if (const auto* presence = std::get_if<Topics::Presence>(&at))
    return on_presence(*presence, message.payload, message.retained);
  if (message.topic == topics_.inbox_probe(own_) || message.topic == topics_.presence_probe(own_))
    return set_vouched(false);
  ++counters_.foreign;
  log_.warning("foreign", fmt::format("a message at {}, which is not a topic of ours", message.topic));
}

/// Whether the rights of the broker let this user write in the name of another; then others may write in its name.
void MqttEcology::set_vouched(bool vouched) {
  probed_ = true;
  if (std::exchange(vouched_, vouched) == vouched) return;
  if (!vouched && !options_.trust_broker && (options_.judge || options_.realm))
    log_.unlimited().warning(
        "the broker lets users write in each other's names: who others are counts for nothing until it has rights by "
        "user, or `trust_broker: yes`");
  judge_again();
}

void MqttEcology::foreign(const Line& from, const std::string& what) {
  ++counters_.foreign;
  log_.warning("foreign " + from.user, fmt::format("{} of user {}: dropped", what, from.user));
}

void MqttEcology::on_presence(const Topics::Presence& at, std::string_view payload, bool retained) {
  if (payload.size() > kMaxPresence) return foreign(at.line, fmt::format("presence of {} bytes", payload.size()));
  const bool here = !payload.empty() && payload != kLeft;
  auto component = here && at.component ? read_component(payload) : ComponentShown{};
  const auto line = here && !at.component ? read_line(payload) : LineShown{};
  if (!component || !line) return foreign(at.line, component ? line.error().text : component.error().text);
  if (at.line.user == own_.user) note_own(at, component->incarnation, here);
  if (!search_.wants(at.line, at.component)) return;
  if (payload == kLeft && at.component) return presence_.leave(at.line, *at.component);
  if (!here) return at.component ? presence_.fade(at.line, *at.component) : presence_.hide(at.line);
  if (at.component && at.line != own_ &&
      !may_have(at.line.user, *at.component))  // it is kept: with a newer realm it may
    foreign(at.line, fmt::format("presence of component {}, an id of another user,", number(*at.component)));
  const bool room =
      at.component ? presence_.show(at.line, *at.component, std::move(*component)) : presence_.show(at.line, *line);
  if (room && at.component && search_.line(at.line)) presence_.await(at.line);
  if (room) return void(shown_lately_ += retained ? 0 : 1);
  search_.forget(at.line);
  log_.warning("presence " + at.line.user,
               fmt::format("user {} shows too many components, or all together do: some are ignored", at.line.user));
}

void MqttEcology::on_frame(const Line& from, ByteView payload) {
  ByteView entries;
  const auto head = read_head(payload, entries);
  if (!head) return foreign(from, head.error().text);
  if (is_own(head->source, head->source_incarnation))
    return foreign(from, fmt::format("a frame in the name of component {} of this process", number(head->source)));
  if (const auto own = own_lines_.find(from); own != own_lines_.end()) own->second.heard = true;
  take(from, *head, entries);
}

bool MqttEcology::is_own(OwnerId id, std::uint64_t incarnation) const {
  const auto* link = links_.find(id);
  return link && link->attached() && link->incarnation() == incarnation;
}

/// Whether the message comes from the connection of the component that counts, and is for the present start of an own
/// one.
void MqttEcology::take(const Line& from, const FrameHead& head, ByteView entries) {
  auto* link = links_.find(head.target);
  if (!link || !link->attached() || link->incarnation() != head.target_incarnation) return;
  if (options_.realm && from != own_ && !options_.realm->member(from.user)) return foreign(from, "a frame");
  if (head.number == 0 && !entries.empty()) return on_check(from, head, entries);
  const auto source = presence_.reached(head.source);
  const bool known = source && source->shown.incarnation == head.source_incarnation;
  if (!known) return hold(from, head, entries);
  if (source->line.user != from.user)
    return foreign(from, fmt::format("a frame in the name of component {}", number(head.source)));
  if (source->line != from && from != own_) search_.line(from);  // its new connection
  heard_[head.source] = scheduler_.now();
  link->arrived(head, entries);
}

/// No component searched for the sender so far, or its presence has not arrived: the message is kept for a moment; else
/// the sender sends it again.
void MqttEcology::hold(const Line& from, const FrameHead& head, ByteView entries) {
  search_.line(from);
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
  links_.each([&](MqttLink& link) { link.review(id, how); });
  if (alive.ended()) return;
  if (!presence_.reached(id)) return search_.forget(id);
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

// -- for links

Channel::Sent MqttEcology::send(const FrameHead& head, ByteView entries) {
  if (is_own(head.target, head.target_incarnation)) {
    lifetime_.post(scheduler_, [this, head, kept = Bytes(entries.begin(), entries.end())] { take(own_, head, kept); });
    return Channel::Sent::kYes;
  }
  const auto target = presence_.reached(head.target);
  const bool ended =
      target && (target->line == own_ || presence_.is_here(target->line));  // of this process, and still shown
  return target && !ended ? send_to(target->line, head, entries) : Channel::Sent::kLater;
}

/// A broker reports at QoS 1 only that a message is too large, so the first messages of a size use QoS 1.
Channel::Sent MqttEcology::send_to(const Line& to, const FrameHead& head, ByteView entries) {
  const auto packed = packing_.packed(entries);
  const auto sent = packed ? ByteView(*packed) : entries;
  const auto size = sent.size();
  if (size > largest_) return Channel::Sent::kTooLarge;
  transport::MqttPublication frame;
  frame.topic = topics_.inbox(to, own_);
  frame.payload = base::as_text(frame_of(head, sent));
  if (answers_ && size > std::max(proven_, Channel::kFrameBytes) && large_.size() < kMaxLarge) {
    frame.qos = 1;
    frame.number = ++large_number_;
    large_[frame.number] = {head.source, head.target, head.stream, head.number, size};
  }
  return publish(std::move(frame)) ? Channel::Sent::kYes : Channel::Sent::kLater;
}

void MqttEcology::on_taken(const transport::MqttOutcome& outcome) {
  if (const auto found = large_.find(outcome.number); found != large_.end()) {
    proven_ = std::max(proven_, found->second.size);
    large_.erase(found);
  }
}

void MqttEcology::on_not_taken(const transport::MqttOutcome& outcome, const Error& why) {
  const auto large = large_.extract(outcome.number);
  if (large.empty() || why.code != ErrorCode::kOutOfRange)
    return void(log_.warning("not taken", fmt::format("the broker does not take {}: {}", outcome.topic, why.text)));
  const auto& one = large.mapped();
  largest_ = std::min(largest_, one.size - 1);  // until the connection ends: then it may have other settings
  if (auto* link = links_.find(one.source)) link->too_large(one.target, one.stream, one.number);
}

/// One of version 5 would say so.
bool MqttEcology::may_swallow(std::size_t size) const {
  return !answers_ && size > Channel::kFrameBytes;
}

std::uint32_t MqttEcology::credit() const {
  const auto senders = std::max<std::size_t>(heard_.size(), 1);
  return std::clamp(static_cast<std::uint32_t>(kQueue / senders), kMinCredit, Channel::kMaxCredit);
}

std::size_t MqttEcology::channels() const {
  std::size_t all = 0;
  for (const auto& [id, link] : links_.all()) all += link->channels();
  return all;
}

Result<std::unique_ptr<Link>> MqttEcology::join(OwnerId id) {
  return join_as({id, transport::host_id("host"), [this, id] {
                    if (displaced_) displaced_(id);
                  }});
}

Result<std::unique_ptr<Link>> MqttEcology::join_as(StandIn who) {
  if (links_.find(who.id)) return fail(already_here(who.id));
  if (options_.realm && carrier_of(who.host) != model::kNoOwner && !may_have(own_.user, who.id))
    return fail(ErrorCode::kRefused,
                fmt::format("{0} may not be {1} at the broker: allow it by `rubicon trust change {0}` "
                            "with `--island {1}` and the islands that it has",
                            own_.user, number(who.id)));
  return std::make_unique<MqttLink>(*this, std::move(who));
}

}  // namespace rubicon::tuples::mqtt
