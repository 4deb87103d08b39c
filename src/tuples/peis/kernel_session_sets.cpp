#include <fmt/format.h>

#include <algorithm>

#include "tuples/peis/kernel_session.h"
#include "tuples/peis/translation.h"

namespace rubicon::tuples::peis {

namespace {

constexpr std::string_view kArrived = "arrived; the PEIS kernel does not say whether it was accepted";
constexpr std::string_view kNotSent = "its time to live ended before the PEIS kernel had room for it: it was not sent";
constexpr std::string_view kNotAcknowledged =
    "the PEIS kernel did not acknowledge it within 11.6 s; it may have arrived all the same";

}  // namespace

Result<void> KernelSession::check(const RemoteSet& set) const {
  if (auto fits = check_peis_key(set.key); !fits) return fits;
  if (set.expected_sequence)
    return fail(ErrorCode::kUnsupported,
                fmt::format("setting '{}': {} is a PEIS kernel, which compares no sequences", set.key, number(peer_)));
  if (!has_room(set.value.size())) return fail(ErrorCode::kBusy, name() + " does not accept requests at the moment");
  return {};
}

Result<void> KernelSession::remote_set(const RemoteSet& set) {
  if (auto good = check(set); !good) return good;
  if (set.time_to_live < Duration(0)) return {};  // the space has answered it
  const auto ends = set.time_to_live > Duration(0) ? context_.scheduler.now() + set.time_to_live : SteadyTime::max();
  sets_.push_back({set.request, folded(set.key), set.value});
  const auto done = guarded([this, request = set.request](Outcome outcome) { arrived(request, outcome); });
  if (set.append) {
    send(Port::kSetAppend, encode_append(set), done, ends);
  } else {
    send(Port::kSetRemote, encode(set), done, ends);
  }
  return {};
}

Bytes KernelSession::encode(const RemoteSet& set) const {
  const auto wall = context_.scheduler.wall_now();
  const auto value = to_wire(set.value, set.media_type);
  NetworkTuple out;
  out.owner = peer_;
  out.key = set.key;
  out.creator = context_.self;
  out.write_time = wall;
  out.user_time = set.user_time;
  out.expire_time =
      set.lifetime > Duration(0) ? wall + std::chrono::ceil<std::chrono::microseconds>(set.lifetime) : WallTime{};
  out.encoding = value.encoding;
  out.media_type = media_type_on_wire(set.media_type);
  out.data = value.data;
  out.sequence = 0;  // = one more; kernels take over any other (section 6.1, 8)
  return write_set_remote(out);
}

/// The NUL at the end takes the place of the one that it replaces; binary tuples have none.
Bytes KernelSession::encode_append(const RemoteSet& set) const {
  const auto* copy = copies_.find(set.key);
  const bool binary = copy && copy->encoding == Encoding::kBinary;
  const auto difference = binary ? set.value : to_wire(set.value, set.media_type).data;
  SetAppend out;
  out.prototype.owner = peer_;
  out.prototype.key = set.key;
  out.difference = difference;
  return write(out);
}

/// The outcome of the transport: all that a kernel says.
void KernelSession::arrived(std::uint64_t request, Outcome outcome) {
  const auto found =
      std::find_if(sets_.begin(), sets_.end(), [&](const PendingSet& set) { return set.request == request; });
  if (found == sets_.end()) return;  // the new value came first
  sets_.erase(found);
  answer(request, outcome, 0);
}

/// A new value that this component wrote: the kernel has applied the set.
void KernelSession::saw(const KernelCopies::Copy& copy) {
  if (copy.creator != context_.self || sets_.empty()) return;
  const auto key = folded(copy.key);
  const auto value = from_kernel(copy.encoding, copy.data, copy.media_type);
  const auto found = std::find_if(sets_.begin(), sets_.end(),
                                  [&](const PendingSet& set) { return set.key == key && set.value == value; });
  if (found == sets_.end()) return;
  const auto request = found->request;
  sets_.erase(found);
  answer(request, Outcome::kDelivered, copy.sequence);
}

void KernelSession::answer(std::uint64_t request, Outcome outcome, std::uint64_t sequence) {
  Reply reply;
  reply.to = context_.self;
  reply.request = request;
  reply.sequence = sequence;
  if (outcome == Outcome::kDelivered) {
    if (sequence == 0) reply.text = kArrived;
  } else {
    const bool is_gone = outcome == Outcome::kHostGone;
    reply.verdict = is_gone                        ? Verdict::kNoSuchOwner
                    : outcome == Outcome::kNotSent ? Verdict::kExpired
                                                   : Verdict::kTimedOut;
    reply.code = is_gone ? ErrorCode::kNotFound : ErrorCode::kExpired;
    reply.text = is_gone ? name() + " is gone; the request may have arrived"
                         : std::string(outcome == Outcome::kNotSent ? kNotSent : kNotAcknowledged);
  }
  if (context_.listener) context_.listener->on_reply(peer_, reply);
}

void KernelSession::on_set(ByteView body) {
  const auto read = read_set_remote(body);
  if (!read) return bad(read.error());
  if (*read->owner != context_.self) return void(++context_.counters.foreign_tuples);
  if (folded(read->key) == kQuitKey) {
    ++context_.counters.ignored_quits;
    context_.log.warning("quit " + name(),
                         fmt::format("{} set {} here, which would end a PEIS kernel: ignored", name(), kQuitKey));
    return;
  }
  RemoteSet set;
  set.key = read->key;
  set.value = from_kernel(*read->encoding, *read->data, read->media_type);
  set.media_type = read->media_type;
  set.user_time = *read->user_time;
  if (const auto ends = *read->expire_time; ends != WallTime{}) {
    const auto from =
        read->write_time.value_or(WallTime{}) == WallTime{} ? context_.scheduler.wall_now() : *read->write_time;
    set.lifetime = std::max<Duration>(ends - from, Duration(1));
    if (ends == kDeleteTime) {
      return refused("delete", read->key, "only its owner can");
    }
  }
  ask_owner(std::move(set));
}

/// A prototype: the append is for all own tuples that match.
void KernelSession::on_append(ByteView body) {
  const auto read = read_set_append(body);
  if (!read) return bad(read.error());
  const auto& prototype = read->prototype;
  if (prototype.owner && *prototype.owner != context_.self) return;
  const auto pattern = from_kernel_pattern(prototype.key);
  if (!pattern) return bad(pattern.error());
  std::vector<std::string> keys;
  view_.keys.each(*pattern, [&](const std::string& key) {
    if (keys.size() < kMaxAppended) keys.push_back(key);
  });
  if (keys.empty()) refused("append to", prototype.key, "there is no such tuple");
  const auto encoding = prototype.encoding.value_or(Encoding::kAscii);
  for (const auto& key : keys) {
    RemoteSet set;
    set.key = key;
    set.value = from_kernel(encoding, read->difference, {});
    set.media_type.clear();
    set.append = true;
    ask_owner(std::move(set));
  }
}

/// The policy of the space decides; the kernel does not learn how.
void KernelSession::ask_owner(RemoteSet set) {
  if (const auto* spelling = view_.keys.spelling(set.key)) set.key = *spelling;
  set.from = peer_;
  set.owner = context_.self;
  set.request = ++last_set_;
  asked_[set.request] = {set.key, set.append};
  while (asked_.size() > kMaxAsked) asked_.erase(asked_.begin());
  if (context_.listener) context_.listener->on_remote_set(set);
}

void KernelSession::reply(const Reply& reply) {
  const auto asked = asked_.extract(reply.request);
  if (reply.verdict == Verdict::kApplied) return;
  const bool is_append = !asked.empty() && asked.mapped().append;
  refused(is_append ? "append to" : "set", asked.empty() ? std::string_view() : asked.mapped().key, reply.text);
}

/// A line for each key, and after a minute one for those that had none.
void KernelSession::refused(std::string_view what, std::string_view key, std::string_view why) {
  ++context_.counters.refused_sets;
  auto subject = fmt::format("{} {}", what, key);
  if (named_refusals_.contains(subject)) return;
  if (named_refusals_.empty()) refusals_due_.advance_to(context_.scheduler.now() + kRefusalsEach);
  if (named_refusals_.size() >= kMaxNamedRefusals) {
    if (more_refusals_.size() < kMaxMoreRefusals) more_refusals_.insert(std::move(subject));
    return;
  }
  context_.log.unlimited().info(fmt::format("{} asks to {} {}: refused: {}", name(), what, model::quoted(key), why));
  named_refusals_.insert(std::move(subject));
}

void KernelSession::tell_more_refusals() {
  if (const auto more = std::exchange(more_refusals_, {}).size(); more > 0)
    context_.log.unlimited().info(fmt::format("requests of {} for {} more tuples are refused", name(), more));
  named_refusals_.clear();
}

}  // namespace rubicon::tuples::peis
