#include "tuples/peis/kernel_session.h"

#include <utility>

#include "tuples/peis/patterns.h"

namespace rubicon::tuples::peis {

KernelSession::KernelSession(SessionContext& context, OwnerId peer, View& view)
    : Session(context, peer),
      view_(view),
      again_(context.scheduler, [this] { during([this] { request_again(); }); }),
      expiry_(context.scheduler, [this] { expire_copies(); }),
      refusals_due_(context.scheduler, [this] { tell_more_refusals(); }) {}

void KernelSession::receive(Port port, ByteView body) {
  switch (port) {
    case Port::kPush: return on_push(body);
    case Port::kPushAppended: return on_appended(body);
    case Port::kSubscribe: return on_subscribe(body);
    case Port::kUnsubscribe: return on_unsubscribe(body);
    case Port::kSetRemote: return on_set(body);
    case Port::kSetAppend: return on_append(body);
    default: return;  // of components of ours that did not say hello
  }
}

Done KernelSession::guarded(std::function<void(Outcome)> call) {
  return lifetime_.guard([this, call = std::move(call)](Outcome outcome) { during([&] { call(outcome); }); });
}

/// Its tuples count again whatever their numbers; it has none of our subscriptions, and gets our tuples again.
void KernelSession::forgotten() {
  copies_.begin_round();
  requests_.clear();
  due_requests_.clear();
  lost_deletes_.clear();
  for (auto& [id, subscription] : subscriptions_) subscription.waits = true;
  for (const auto id : subscribers_.begin_again()) join(id);
  deliver(Restart{});
}

void KernelSession::back() {
  request_again();
}

std::vector<std::string> KernelSession::patterns() const {
  std::vector<std::string> all;
  for (const auto& [name, entry] : subscribers_.entries()) all.push_back(entry.pattern);
  return all;
}

void KernelSession::ended() {
  for (const auto& set : std::exchange(sets_, {})) answer(set.request, Outcome::kHostGone, 0);
}

}  // namespace rubicon::tuples::peis
