#include <fmt/format.h>

#include "tuples/dds/dds_link.h"
#include "wire.h"

namespace rubicon::tuples::dds {

namespace {

ByteView view(const dds_sequence_octet& octets) {
  return {octets._buffer, octets._length};
}

}  // namespace

/// Processes the samples that arrived. Each listener call may detach the link.
void DdsLink::drain(unsigned sources) {
  if (!participant_) return;
  if (listener_ && (sources & Signal::kPresence) != 0 && take_presences()) signal_.raise(Signal::kPresence);
  if (listener_ && (sources & Signal::kInterests) != 0 && take_interests()) signal_.raise(Signal::kInterests);
  if (listener_ && (sources & Signal::kFrames) != 0 && take_frames()) signal_.raise(Signal::kFrames);
  if (listener_ && (sources & Signal::kWriter) != 0) flush();
  if (listener_ && writers_.is_long()) drop_gone_writers();
}

bool DdsLink::take_interests() {
  struct News {
    InterestKey key;
    Participant participant{};
    std::optional<SubscriptionSpec> spec;
  };
  std::vector<News> news;
  const auto count =
      take<rubicon_wire_Interest>(interest_reader_.get(), kSamples, [&](const auto& sample, const auto& info) {
        stores_->interest_quota.taken(info.publication_handle, info.instance_handle);
        News one{{OwnerId(sample.subscriber), sample.incarnation, sample.slot}, {}, {}};
        const auto* writer = writers_.find(interest_reader_.get(), info.publication_handle);
        if (writer) one.participant = writer->participant;
        if (info.instance_state != DDS_IST_ALIVE) {
          stores_->interest_quota.ended(info.publication_handle, info.instance_handle);
        } else {
          if (!writer || !info.valid_data) return;
          if (participants_.is_banned(writer->participant)) return stores_->interest_quota.ban(info.publication_handle);
          const auto content = view(sample.content);
          auto spec = distant::read_subscription(content);
          if (!spec) {
            return warn(fmt::format("interest of {}", sample.subscriber),
                        fmt::format("subscription of component {}: {}", sample.subscriber, spec.error().text));
          }
          one.spec = std::move(*spec);
        }
        if (one.key.subscriber != self_) news.push_back(std::move(one));
      });
  for (auto& one : news) {
    if (listener_) on_interest(one.key, one.participant, std::move(one.spec));
  }
  return count >= kSamples;
}

/// The end of one whose writer is gone has no participant, and ends with that one.
void DdsLink::on_interest(const InterestKey& key, const Participant& who, std::optional<SubscriptionSpec> spec) {
  const auto id = key.subscriber;
  const auto* peer = find_up(id);
  const bool counts = peer && peer->incarnation == key.incarnation && peer->participant == who;
  if (const auto* before = counts ? interests_.find(key, who) : nullptr) listener_->on_unsubscribe(id, before->id);
  if (!listener_) return;
  if (!spec) return interests_.erase(key, who);
  if (!interests_.put(key, who, *spec)) {
    return warn(fmt::format("interests {}", number(id)),
                fmt::format("component {} has too many or too long subscriptions: one is ignored", number(id)));
  }
  if (counts) listener_->on_subscribe(id, *spec);
}

/// True: more may have arrived.
bool DdsLink::take_frames() {
  struct News {
    EarlyFrames::Sender sender;
    Bytes content;
  };
  std::vector<News> news;
  const auto count = take<rubicon_wire_Frame>(frame_reader_.get(), kSamples, [&](const auto& sample, const auto& info) {
    if (!info.valid_data || sample.target_incarnation != incarnation_) return;
    const auto* writer = writers_.find(frame_reader_.get(), info.publication_handle);
    // Without a writer: it went before its first frame was read, so its component is not known.
    if (!writer || !writer->source || participants_.is_banned(writer->participant)) return;
    const OwnerId source{sample.source};
    if (*writer->source != source)
      return warn(
          fmt::format("forged {}", sample.source),
          fmt::format("frames in the name of component {} come from another component: dropped", sample.source));
    const auto bytes = view(sample.content);
    news.push_back({{source, sample.source_incarnation, writer->participant}, Bytes(bytes.begin(), bytes.end())});
  });
  for (const auto& one : news) {
    if (listener_) on_frame(one.sender, one.content);
  }
  return count >= kSamples;
}

void DdsLink::on_frame(const EarlyFrames::Sender& sender, ByteView content) {
  if (sender.id == self_) return id_conflicts_.on_frame(sender.incarnation, content);
  const auto* peer = find_up(sender.id);
  if (!peer || sender.incarnation > peer->incarnation) return buffer(sender, content);
  if (sender.incarnation < peer->incarnation) return;
  if (sender.participant == peer->participant) return deliver(sender.id, content);
  buffer(sender, content);  // it may be the component, whose former participant is not lost here yet
}

void DdsLink::buffer(const EarlyFrames::Sender& sender, ByteView content) {
  if (!early_frames_.add(sender, content, scheduler_.now()))
    return warn("held", "frames arrived before the presence of their component, and the buffer is full: dropped");
  if (!early_timer_.pending()) early_timer_ = scheduler_.after(lease_, [this] { drop_expired_frames(); });
}

void DdsLink::drop_expired_frames() {
  early_frames_.drop_until(scheduler_.now() - lease_);
  if (!early_frames_.empty()) early_timer_ = scheduler_.after(lease_, [this] { drop_expired_frames(); });
}

void DdsLink::deliver(OwnerId id, ByteView content) {
  reading_from_ = id;
  reading_sent_.reset();
  if (auto read = distant::read_frame(content, id, self_, *this); !read)
    warn(fmt::format("frame {}", number(id)), read.error().text);
}

void DdsLink::on_changes(std::span<const Change> changes) {
  if (listener_) listener_->on_changes(reading_from_, changes);
}

void DdsLink::on_reply(Reply&& reply) {
  if (listener_ && !listener_->on_reply(reading_from_, reply))
    warn(fmt::format("replies of {}", number(reading_from_)),
         fmt::format("component {} answered a request that it was not asked: ignored", number(reading_from_)));
}

}  // namespace rubicon::tuples::dds
