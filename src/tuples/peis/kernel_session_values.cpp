#include <fmt/format.h>

#include <algorithm>

#include "tuples/peis/kernel_session.h"
#include "tuples/peis/translation.h"

namespace rubicon::tuples::peis {

void KernelSession::publish(const Change& change) {
  std::visit([this](const auto& one) { publish(one); }, change);
}

/// Whether kernels can have a tuple with this key. The tuple stays on the other engines.
bool KernelSession::is_publishable(std::string_view key) {
  std::string why;
  if (const auto fits = check_peis_key(key); !fits) {
    why = fits.error().text;
  } else if (KernelTuples::owns(key)) {
    why = fmt::format("key {} is one that each PEIS component publishes about itself", model::quoted(key));
  } else if (const auto* spelling = view_.keys.spelling(key); spelling && *spelling != key) {
    why = fmt::format(
        "key {} differs only in case from another one of this component, which is one tuple to PEIS kernels",
        model::quoted(key));
  } else {
    return true;
  }
  ++context_.counters.refused_keys;
  context_.log.error("key " + std::string(key.substr(0, kMaxPeisKey)), why + ": not published to PEIS kernels");
  return false;
}

void KernelSession::publish(const TupleSet& set) {
  const auto& tuple = set.tuple;
  if (!is_publishable(tuple.key)) return;
  const auto value = to_wire(tuple.value, tuple.media_type);
  auto out = tuple_on_wire(tuple, value, context_.self);
  if (!subscribers_.wants(tuple.key, out.media_type, value.data, *out.creator)) return;
  out.sequence = view_.keys.number_of(tuple);
  send(Port::kPush, write_push(out), watched({}));
}

/// A kernel lets its copies expire by itself.
void KernelSession::publish(const TupleGone& gone) {
  if (gone.how != EventKind::kDeleted || !check_peis_key(gone.key) || KernelTuples::owns(gone.key)) return;
  if (const auto* spelling = view_.keys.spelling(gone.key); spelling && *spelling != gone.key) return;
  push_gone(std::string(gone.key), view_.keys.number_of(gone));
}

void KernelSession::push_gone(const std::string& key, std::uint32_t number) {
  static constexpr std::string_view kNothing("\0", 1);
  NetworkTuple out;
  out.owner = out.creator = context_.self;
  out.key = key;
  out.write_time = context_.scheduler.wall_now();
  out.user_time = WallTime{};
  out.expire_time = kDeleteTime;
  out.encoding = Encoding::kAscii;
  out.media_type = media_type_on_wire({});
  out.data = kNothing;
  out.sequence = number;
  send(Port::kPush, write_push(out), watched({key, number}));
}

void KernelSession::publish(const SnapshotEnd& end) {
  auto* spelling = subscribers_.find(end.subscription);
  if (!spelling) return;
  spelling->snapshot_under_way = false;
  if (std::exchange(spelling->again, false)) later([this, id = end.subscription] { join(id); });
}

/// For a push: one that is given up is made again, as kernels do (peis.md, section 6.1, 2).
Done KernelSession::watched(const Deleted& deleted) {
  return guarded([this, deleted](Outcome outcome) {
    if (outcome == Outcome::kGivenUp) lost(deleted);
  });
}

void KernelSession::lost(const Deleted& deleted) {
  ++context_.counters.lost_pushes;
  context_.log.warning("pushes to " + name(),
                       fmt::format("{} did not acknowledge a tuple: all that it subscribed to "
                                   "are sent again each {} s until it does",
                                   name(), std::chrono::duration_cast<std::chrono::seconds>(kRequestAgain).count()));
  if (!deleted.key.empty() && lost_deletes_.size() < kMaxLostDeletes) lost_deletes_[deleted.key] = deleted.number;
  lost_pushes_ = true;
  again_.advance_to(context_.scheduler.now() + kRequestAgain);
}

void KernelSession::push_again() {
  for (const auto& [key, number] : std::exchange(lost_deletes_, {})) {
    if (!view_.keys.spelling(key)) push_gone(key, number);
  }
  for (const auto& [key, tuple] : view_.tuples.all()) push_kernel_tuple(key);
  for (const auto id : subscribers_.ids()) {
    auto* spelling = subscribers_.find(id);
    if (spelling && spelling->snapshot_under_way) spelling->again = true;
    join(id);
  }
}

void KernelSession::push_kernel_tuple(const std::string& key) {
  const auto found = view_.tuples.all().find(key);
  if (found == view_.tuples.all().end()) return;
  subscribers_.each_for(key, [&](const KernelSubscribers::Entry&) { due_tuples_.insert(found->first); });
  send_due();
}

/// The key as we subscribed to it, else as the kernel spells it.
std::string_view KernelSession::own_spelling(std::string_view key) const {
  const auto found = spellings_.find(folded(key));
  return found == spellings_.end() ? key : std::string_view(found->second);
}

void KernelSession::deliver_copy(const KernelCopies::Copy& copy) {
  deliver(TupleSet{view_of(copy, own_spelling(copy.key))});
}

/// The space counts the lifetimes of its copies by itself.
void KernelSession::expire_copies() {
  copies_.expire(context_.scheduler.now());
  expiry_.set_at(copies_.next_expiry());
}

void KernelSession::on_push(ByteView body) {
  const auto read = read_push(body);
  if (!read) return bad(read.error());
  if (*read->owner != peer_) return void(++context_.counters.foreign_tuples);
  if (!model::check_key(read->key)) return void(++context_.counters.unknown_keys);
  if (*read->expire_time == kDeleteTime) return on_delete(*read);
  const auto news = copies_.take(*read, context_.scheduler.now());
  expiry_.advance_to(copies_.next_expiry());
  if (news == KernelCopies::News::kOld) return;
  if (news == KernelCopies::News::kNoRoom) return not_kept(1);
  const auto& copy = *copies_.find(read->key);
  saw(copy);
  deliver_copy(copy);
}

void KernelSession::not_kept(std::uint64_t values) {
  context_.counters.copies_not_kept += values;
  context_.log.warning("copies of " + name(), name() + " has too many tuples: some are dropped");
}

/// A delete is a set that expired in 1970.
void KernelSession::on_delete(const NetworkTuple& tuple) {
  const auto* present = copies_.find(tuple.key);
  if (!present || (present->confirmed && *tuple.sequence < present->number)) return;
  const auto gone = copies_.remove(tuple.key);
  deliver(TupleGone{EventKind::kDeleted, own_spelling(gone->key), gone->sequence + 1});
}

void KernelSession::on_appended(ByteView body) {
  const auto read = read_push_appended(body);
  if (!read) return bad(read.error());
  if (read->tuple.owner != peer_) return void(++context_.counters.foreign_tuples);
  std::vector<std::string> keys;
  const auto refused = copies_.refused_appends();
  for (const auto* copy : copies_.append(*read)) keys.push_back(copy->key);
  if (copies_.refused_appends() > refused) not_kept(copies_.refused_appends() - refused);
  for (const auto& key : keys) {
    const auto* copy = copies_.find(key);
    if (!copy) continue;
    saw(*copy);
    deliver_copy(*copy);
  }
}

}  // namespace rubicon::tuples::peis
