#include "tuples/peis/own_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "tuples/peis/fields.h"
#include "tuples/peis/own_messages.h"
#include "tuples/peis/translation.h"

namespace rubicon::tuples::peis {

namespace {

constexpr std::size_t kMaxPatterns = 10'000;  ///< the space has the same bound
constexpr std::string_view kNothing("\0", 1);

Error too_long(std::string_view key) {
  return {ErrorCode::kOutOfRange, fmt::format("key {} has {} characters, a message of PEIS has room for {}",
                                              model::quoted(key), key.size(), kMaxPeisKey)};
}

WallTime end_of(WallTime from, Duration lifetime) {
  return from + std::chrono::ceil<std::chrono::microseconds>(lifetime);
}

}  // namespace

void OwnSession::publish(const Change& change) {
  std::visit([this](const auto& one) { publish(one); }, change);
}

void OwnSession::publish(const TupleSet& set) {
  const auto& tuple = set.tuple;
  if (tuple.key.size() > kMaxPeisKey) {
    ++context_.counters.refused_keys;
    context_.log.error("long key", too_long(tuple.key).text + ": not published on this engine");
    return;
  }
  const auto value = to_wire(tuple.value, tuple.media_type);
  auto out = tuple_on_wire(tuple, value, context_.self);
  out.sequence = static_cast<std::uint32_t>(tuple.sequence - 1) & kMaxId;
  out.annex = to_annex(PushAnnex{tuple.sequence, EventKind::kSet, tuple.media_type.empty()});
  write_push_into(out, body_);
  send(Port::kPush, body_);
}

/// Has the form of a kernel's delete; the annex says whether the tuple expired.
void OwnSession::publish(const TupleGone& gone) {
  if (gone.key.size() > kMaxPeisKey) return;
  NetworkTuple out;
  out.owner = out.creator = context_.self;
  out.key = gone.key;
  out.write_time = context_.scheduler.wall_now();
  out.user_time = WallTime{};
  out.expire_time = kDeleteTime;
  out.encoding = Encoding::kAscii;
  out.media_type = media_type_on_wire({});
  out.data = kNothing;
  out.sequence = static_cast<std::uint32_t>(gone.sequence) & kMaxId;
  out.annex = to_annex(PushAnnex{gone.sequence, gone.how, false});
  write_push_into(out, body_);
  send(Port::kPush, body_);
}

void OwnSession::publish(const SnapshotEnd& end) {
  send(Port::kSnapshot, write_control(end));
}

void OwnSession::publish(const Restart& restart) {
  send(Port::kSnapshot, write_control(restart));
}

/// A pattern that is too long for a message matches no key that would fit: its snapshot is empty.
void OwnSession::subscribe(const SubscriptionSpec& spec) {
  if (spec.pattern.key.size() > kMaxPeisKey) {
    ++context_.counters.refused_patterns;
    context_.log.error("long pattern", too_long(spec.pattern.key).text + ": it matches nothing on this engine");
    return end_snapshot(spec.id);
  }
  subscription_changes_[spec.id] = spec;
  send_due();
}

void OwnSession::unsubscribe(std::uint32_t id) {
  subscription_changes_[id] = std::nullopt;
  send_due();
}

bool OwnSession::send_next() {
  if (std::exchange(forget_, false)) {
    send(Port::kSnapshot, write_forget());
  } else if (!subscription_changes_.empty()) {
    const auto change = subscription_changes_.extract(subscription_changes_.begin());
    change.mapped() ? send_subscribe(*change.mapped()) : send_unsubscribe(change.key());
  } else if (const auto summary = std::exchange(summary_, std::nullopt)) {
    send(Port::kSummary, base::as_bytes(*summary));
  } else {
    return false;
  }
  return true;
}

void OwnSession::send_subscribe(const SubscriptionSpec& spec) {
  Subscribe out;
  out.prototype.owner = peer_;
  out.prototype.key = spec.pattern.key;
  out.prototype.annex = to_annex(SubscribeAnnex{spec.id, spec.flow});
  send(Port::kSubscribe, write(out));
}

void OwnSession::send_unsubscribe(std::uint32_t id) {
  Unsubscribe out;
  out.owner = peer_;
  out.annex = to_annex(SubscribeAnnex{id, {}});
  send(Port::kUnsubscribe, write(out));
}

Result<void> OwnSession::remote_set(const RemoteSet& set) {
  if (set.key.size() > kMaxPeisKey) return fail(too_long(set.key));
  if (!has_room(set.value.size())) return fail(ErrorCode::kBusy, name() + " does not accept requests at the moment");
  if (set.time_to_live < Duration(0)) return {};  // the space has answered it
  const auto value = to_wire(set.value, set.media_type);
  const auto wall = context_.scheduler.wall_now();
  SetAnnex annex{set.request, std::nullopt,          set.expected_sequence, set.time_to_live_given,
                 set.append,  set.media_type.empty()};
  if (set.time_to_live > Duration(0)) annex.time_to_live = set.time_to_live;
  NetworkTuple out;
  out.owner = peer_;
  out.key = set.key;
  out.creator = context_.self;
  out.write_time = wall;
  out.user_time = set.user_time;
  out.expire_time = set.lifetime > Duration(0) ? end_of(wall, set.lifetime) : WallTime{};
  out.encoding = value.encoding;
  out.media_type = media_type_on_wire(set.media_type);
  out.data = value.data;
  out.sequence = 0;
  out.annex = to_annex(annex);
  const auto ends = annex.time_to_live ? context_.scheduler.now() + *annex.time_to_live : SteadyTime::max();
  send(Port::kSetRemote, write_set_remote(out), {}, ends);
  return {};
}

void OwnSession::restamp(Bytes& body, Duration remaining) {
  put_time_to_live(body, remaining);
}

void OwnSession::reply(const Reply& reply) {
  if (has_room(reply.text.size())) return send(Port::kReply, write_reply(reply));
  ++context_.counters.dropped_replies;
  context_.log.warning("replies", name() + " does not read its replies: some are dropped");
}

void OwnSession::describe(const std::string& summary) {
  summary_ = summary;
  send_due();
}

void OwnSession::receive(Port port, ByteView body) {
  switch (port) {
    case Port::kPush: return on_push(body);
    case Port::kSubscribe: return on_subscribe(body);
    case Port::kUnsubscribe: return on_unsubscribe(body);
    case Port::kSetRemote: return on_set(body);
    case Port::kReply: return on_reply(body);
    case Port::kSummary: return context_.listener->on_summary(peer_, base::as_text(body));
    case Port::kSnapshot: return on_control(body);
    default: return;  // of a later version
  }
}

void OwnSession::forgotten() {}

/// Messages that were given up meanwhile may have ended subscriptions, or deleted tuples.
void OwnSession::back() {
  deliver(Restart{});
  forget_ = true;
  subscription_changes_.clear();
  send_due();
}

std::vector<std::string> OwnSession::patterns() const {
  std::vector<std::string> all;
  for (const auto& [id, pattern] : patterns_) all.push_back(pattern);
  return all;
}

void OwnSession::on_push(ByteView body) {
  const auto read = read_push(body);
  if (!read) return bad(read.error());
  const auto annex = read_push_annex(read->annex);
  if (!annex) return;  // it takes us for a kernel until it has our hello, and sends all again when we subscribe
  if (*read->owner != peer_) return void(++context_.counters.foreign_tuples);
  if (annex->kind != EventKind::kSet) return deliver(TupleGone{annex->kind, read->key, annex->sequence});
  TupleView tuple;
  tuple.owner = peer_;
  tuple.key = read->key;
  tuple.value = from_wire(*read->encoding, *read->data);
  tuple.media_type = annex->no_media_type ? std::string_view() : read->media_type;
  tuple.creator = *read->creator;
  tuple.sequence = annex->sequence;
  tuple.write_time = *read->write_time;
  tuple.user_time = *read->user_time;
  tuple.expire_time = *read->expire_time;
  deliver(TupleSet{tuple});
}

void OwnSession::on_subscribe(ByteView body) {
  const auto read = read_subscribe(body);
  if (!read) return bad(read.error());
  const auto annex = read_subscribe_annex(read->prototype.annex);
  if (!annex) return;  // it has no hello of this component yet, and subscribes again when it has
  if (patterns_.size() < kMaxPatterns || patterns_.contains(annex->id)) patterns_[annex->id] = read->prototype.key;
  context_.listener->on_subscribe(peer_,
                                  {annex->id, {read->prototype.owner, std::string(read->prototype.key)}, annex->flow});
}

void OwnSession::on_unsubscribe(ByteView body) {
  const auto read = read_unsubscribe(body);
  if (!read) return bad(read.error());
  const auto annex = read_subscribe_annex(read->annex);
  if (!annex) return;
  patterns_.erase(annex->id);
  context_.listener->on_unsubscribe(peer_, annex->id);
}

void OwnSession::on_set(ByteView body) {
  const auto read = read_set_remote(body);
  if (!read) return bad(read.error());
  const auto annex = read_set_annex(read->annex);
  if (!annex) return bad({ErrorCode::kInvalid, "SET_REMOTE without the annex that components of ours send"});
  if (annex->request <= last_request_) return;  // a repetition, after a hello that came again
  last_request_ = annex->request;
  RemoteSet set;
  set.from = peer_;
  set.owner = context_.self;
  set.request = annex->request;
  set.key = read->key;
  set.value = from_wire(*read->encoding, *read->data);
  set.media_type = annex->no_media_type ? std::string_view() : read->media_type;
  set.user_time = *read->user_time;
  if (*read->expire_time != WallTime{})
    set.lifetime = std::max<Duration>(*read->expire_time - read->write_time.value_or(WallTime{}), Duration(1));
  set.time_to_live = annex->time_to_live.value_or(Duration(0));
  set.time_to_live_given = annex->time_to_live_given;
  set.append = annex->append;
  set.expected_sequence = annex->expected_sequence;
  context_.listener->on_remote_set(set);
}

void OwnSession::on_reply(ByteView body) {
  auto read = read_reply(body);
  if (!read) return bad(read.error());
  read->to = context_.self;
  context_.listener->on_reply(peer_, *read);
}

void OwnSession::on_control(ByteView body) {
  if (is_forget(body)) {
    for (const auto& one : std::exchange(patterns_, {})) {
      if (context_.listener) context_.listener->on_unsubscribe(peer_, one.first);
    }
    return;
  }
  const auto read = read_control(body);
  if (!read) return bad(read.error());
  deliver(*read);
}

}  // namespace rubicon::tuples::peis
