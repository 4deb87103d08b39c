#include "tuples/dds/interests.h"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "tuples/distant/frame_codec.h"
#include "wire.h"  // made from wire.idl

namespace rubicon::tuples::dds {

namespace {

rubicon_wire_Interest interest_of(const OwnStart& own, std::uint32_t slot, const Bytes& content) {
  rubicon_wire_Interest interest{};
  interest.subscriber = number(own.id);
  interest.incarnation = own.incarnation;
  interest.slot = slot;
  interest.content._maximum = interest.content._length = static_cast<std::uint32_t>(content.size());
  interest.content._buffer = const_cast<std::uint8_t*>(content.data());  // written, never changed
  return interest;
}

bool write_slot(dds_entity_t writer, const OwnStart& own, std::uint32_t slot, const Bytes& content) {
  const auto interest = interest_of(own, slot, content);
  if (!content.empty()) return dds_write(writer, &interest) == DDS_RETCODE_OK;
  if (dds_dispose(writer, &interest) != DDS_RETCODE_OK) return false;
  dds_unregister_instance(writer, &interest);
  return true;
}

}  // namespace

void OwnInterests::put(const SubscriptionSpec& spec) {
  std::uint32_t slot = static_cast<std::uint32_t>(slots_.size());
  if (const auto known = slot_of_.find(spec.id); known != slot_of_.end()) {
    slot = known->second;
  } else if (!free_.empty()) {
    slot = *free_.begin();
    free_.erase(free_.begin());
  }
  distant::FrameWriter content;
  content.add(spec);
  slots_[slot] = content.take();
  slot_of_[spec.id] = slot;
  unwritten_.insert(slot);
}

bool OwnInterests::erase(std::uint32_t id) {
  const auto found = slot_of_.find(id);
  if (found == slot_of_.end()) return false;
  slots_[found->second].clear();
  unwritten_.insert(found->second);
  slot_of_.erase(found);
  return true;
}

void OwnInterests::repeat() {
  for (const auto& [slot, content] : slots_) {
    if (!content.empty()) unwritten_.insert(slot);
  }
}

bool OwnInterests::flush(dds_entity_t writer, const OwnStart& own) {
  while (!unwritten_.empty()) {
    const auto slot = *unwritten_.begin();
    const auto& content = slots_[slot];
    if (!write_slot(writer, own, slot, content)) return false;
    unwritten_.erase(unwritten_.begin());
    if (content.empty()) free_.insert(slot);
  }
  return true;
}

bool Subscribers::take() {
  struct News {
    InterestKey key;
    Participant participant{};
    std::optional<SubscriptionSpec> spec;
  };
  std::vector<News> news;
  const auto count = dds::take<rubicon_wire_Interest>(
      entities_.interest_reader(), kSamples, [&](const auto& sample, const auto& info) {
        entities_.interest_quota().taken(info.publication_handle, info.instance_handle);
        News one{{OwnerId(sample.subscriber), sample.incarnation, sample.slot}, {}, {}};
        const auto* writer = presences_.writer(entities_.interest_reader(), info.publication_handle);
        if (writer) one.participant = writer->participant;
        if (info.instance_state != DDS_IST_ALIVE) {
          note_end(info.publication_handle, info.instance_handle);
        } else {
          if (!writer || !info.valid_data) return;
          if (presences_.is_banned(writer->participant)) return entities_.interest_quota().ban(info.publication_handle);
          auto spec = distant::read_subscription({sample.content._buffer, sample.content._length});
          if (!spec) {
            log_.warning(fmt::format("interest of {}", sample.subscriber),
                         fmt::format("subscription of component {}: {}", sample.subscriber, spec.error().text));
            return;
          }
          one.spec = std::move(*spec);
        }
        if (one.key.subscriber != own_.id) news.push_back(std::move(one));
      });
  for (auto& one : news) {
    if (own_.listener) on_interest(one.key, one.participant, std::move(one.spec));
  }
  return count >= kSamples;
}

void Subscribers::note_end(InstanceQuota::Handle publication, InstanceQuota::Handle instance) {
  entities_.interest_quota().ended(publication, instance);
  if (!ended_.add(entities_.interest_reader(), instance)) shared_.overrun();
}

/// The end of one whose writer is gone has no participant, and ends with that one.
void Subscribers::on_interest(const InterestKey& key, const Participant& who, std::optional<SubscriptionSpec> spec) {
  const auto id = key.subscriber;
  const auto* peer = presences_.find_up(id);
  const bool counts = peer && peer->incarnation == key.incarnation && peer->participant == who;
  if (const auto* before = counts ? interests_.find(key, who) : nullptr) own_.listener->on_unsubscribe(id, before->id);
  if (!own_.listener) return;
  if (!spec) return interests_.erase(key, who);
  if (!interests_.put(key, who, *spec)) {
    log_.warning(fmt::format("interests {}", number(id)),
                 fmt::format("component {} has too many or too long subscriptions: one is ignored", number(id)));
    return;
  }
  if (counts) own_.listener->on_subscribe(id, *spec);
}

void Subscribers::met(const Sender& sender) {
  for (const auto& spec : interests_.of(sender.id, sender.incarnation, sender.participant)) {
    if (own_.listener) own_.listener->on_subscribe(sender.id, spec);
  }
}

void Subscribers::drop_gone() {
  auto present = presences_.participants_up();
  for (const auto publication : matched_writers({entities_.interest_reader()})) {
    if (const auto* writer = presences_.writer(entities_.interest_reader(), publication))
      present.insert(writer->participant);
  }
  for (const auto& who : interests_.participants()) {
    if (!present.contains(who)) interests_.erase_all(who);
  }
}

void Subscribers::clear() {
  interests_.clear();
  ended_.clear();
}

}  // namespace rubicon::tuples::dds
