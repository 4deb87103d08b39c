#include "tuples/dds/dds_link.h"

namespace rubicon::tuples::dds {

void DdsLink::on_set(RemoteSet&& set) {
  auto* peer = find_up(reading_from_);
  if (!listener_ || !peer) return;
  if (is_early()) return hold_early(*peer, std::move(set));
  take_set(*peer, std::move(set));
}

void DdsLink::take_set(Peer& peer, RemoteSet&& set) {
  if (set.request <= peer.last_request) return repeat_reply(peer, set.request);
  peer.last_request = set.request;
  if (identities_) replies_.asked(reading_from_, set.request);
  listener_->on_remote_set(set);
}

/// Those that were held come first.
bool DdsLink::is_early() {
  return shared_.catch_up && (!early_sets_.empty() || shared_.catch_up->left() > Duration(0));
}

void DdsLink::hold_early(const Peer& peer, RemoteSet&& set) {
  const auto from = set.from;
  const auto request = set.request;
  if (!early_sets_.add({std::move(set), peer.participant, peer.incarnation, scheduler_.now()}))
    return reply({from, request, Verdict::kRefused, ErrorCode::kBusy,
                  "too many requests wait while this process catches up after its start or sleep"});
  if (!early_sets_timer_.pending())
    early_sets_timer_ = scheduler_.after(shared_.catch_up->left(), [this] { take_early(); });
}

/// Of a sender that is gone, because it was revoked or is met again, nothing is taken: what was not answered it sends
/// again.
void DdsLink::take_early() {
  if (const auto left = shared_.catch_up->left(); left > Duration(0)) {
    early_sets_timer_ = scheduler_.after(left, [this] { take_early(); });
    return;
  }
  for (auto& one : early_sets_.take(scheduler_.now())) {
    reading_from_ = one.set.from;
    auto* peer = listener_ ? find_up(reading_from_) : nullptr;
    if (peer && peer->participant == one.sender && peer->incarnation == one.incarnation)
      take_set(*peer, std::move(one.set));
  }
}

}  // namespace rubicon::tuples::dds
