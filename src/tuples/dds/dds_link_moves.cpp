#include <utility>

#include "tuples/dds/dds_link.h"

namespace rubicon::tuples::dds {

/// What waits in the channels is lost: others ask for snapshots when they meet this component again.
void DdsLink::leave_behind(FormerDomain::Remains& remains) {
  if (!participant_) return;
  if (listener_) take_frames();
  std::vector<OwnerId> there;
  for (auto& [id, peer] : peers_) {
    for (const auto& [incarnation, start] : peer.alive) starts_->note({id, incarnation, 0, false, {}});
    peer.alive.clear();
    if (peer.channel) remains.channels.push_back(std::move(peer.channel));
    if (peer.is_up()) there.push_back(id);
  }
  remains.frame_readers.push_back(frame_reader_.get());
  for (auto* entity : {&presence_reader_, &interest_reader_, &all_subscriber_, &frame_reader_, &frame_subscriber_,
                       &interest_writer_, &interest_publisher_, &presence_writer_, &presence_publisher_,
                       &presence_topic_, &interest_topic_, &frame_topic_, &participant_})
    remains.entities.push_back(std::move(*entity));
  remains.used.push_back(std::exchange(stores_, std::make_shared<ReaderStores>()));
  remains.used.push_back(signal_.used());
  for (const auto id : there) {
    if (auto* peer = listener_ ? find_up(id) : nullptr) peer_down(id, *peer, PeerEvent::kLost);
  }
  forget_others();
}

/// An instance that two participants wrote does not end with one of them.
void DdsLink::drop_interests_of_gone() {
  const auto there = matched_writers({interest_reader_.get()});
  std::set<Participant> present;
  for (const auto publication : there) {
    if (const auto* writer = writers_.find(interest_reader_.get(), publication)) present.insert(writer->participant);
  }
  for (const auto& [id, peer] : peers_) {
    if (peer.is_up()) present.insert(peer.participant);
  }
  for (const auto& who : interests_.participants()) {
    if (!present.contains(who)) interests_.erase_all(who);
  }
}

/// Until the others have what was written: last replies, and that this component left.
void DdsLink::await_receivers() {
  for (const auto& [id, peer] : peers_) {
    if (peer.channel) shared_.patience.await(peer.channel->writer());
  }
  for (const auto* writer : {&interest_writer_, &presence_writer_}) shared_.patience.await(writer->get());
}

}  // namespace rubicon::tuples::dds
