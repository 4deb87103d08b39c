#include "tuples/dds/trust/member/liar.h"

#include <iostream>

#include "transport/host_name.h"
#include "tuples/dds/component_starts.h"
#include "tuples/dds/secure_participant.h"
#include "tuples/dds/take_samples.h"
#include "tuples/distant/frame_codec.h"
#include "wire.h"

namespace rubicon::tuples::dds {

namespace {

Entity publisher_in(const Entity& participant, const std::string& partition) {
  auto qos = make_qos();
  dds_qset_partition1(qos.get(), partition.c_str());
  return Entity(dds_create_publisher(participant.get(), qos.get(), nullptr));
}

void await_reader(const Entity& writer) {
  dds_publication_matched_status_t status{};
  for (int i = 0; i < 3000 && status.current_count == 0; ++i) {
    dds_sleepfor(DDS_MSECS(10));
    dds_get_publication_matched_status(writer.get(), &status);
  }
}

}  // namespace

Liar::Liar(GuardTrust& trust, OwnerId own, const std::string& own_partition) : own_(number(own)) {
  DdsOptions options;
  options.tag = "trust";
  domain_ = Entity(dds_create_domain(options.domain, domain_xml(options).c_str()));
  const auto qos = make_secure_qos(*trust.documents(), trust.guard_library());
  participant_ = Entity(dds_create_participant(options.domain, qos.get(), nullptr));
  const auto topic = [this](const dds_topic_descriptor_t& type, const char* name) {
    return Entity(dds_create_topic(participant_.get(), &type, name, nullptr, nullptr));
  };
  presence_topic_ = topic(rubicon_wire_Presence_desc, "rubicon_presence");
  interest_topic_ = topic(rubicon_wire_Interest_desc, "rubicon_interests");
  frame_topic_ = topic(rubicon_wire_Frame_desc, "rubicon_frames");
  publisher_ = publisher_in(participant_, own_partition);
  auto kept = make_kept_qos();
  interests_ = Entity(dds_create_writer(publisher_.get(), interest_topic_.get(), kept.get(), nullptr));
  dds_qset_liveliness(kept.get(), DDS_LIVELINESS_AUTOMATIC, DDS_SECS(2));
  presences_ = Entity(dds_create_writer(publisher_.get(), presence_topic_.get(), kept.get(), nullptr));
  await_reader(presences_);
  await_reader(interests_);
}

void Liar::obey(const Words& words) {
  const auto& verb = words.at(0);
  if (verb == "frame") return frame(words);
  if (verb == "reply") return reply(words);
  if (verb == "readers") return readers();
  if (verb == "lists") return lists(std::stoi(words.at(1)), words.size() > 2 ? std::stoul(words.at(2)) : 0);
  if (verb == "presences") return presences(std::stoi(words.at(1)), std::stoul(words.at(2)));
  if (verb == "spy") return spy(words.at(1));
  if (verb == "frames") {
    int count = 0;
    take<rubicon_wire_Frame>(spy_.get(), SIZE_MAX, [&](const auto&, const auto&) { ++count; });
    return void(std::cout << "frames " << count << std::endl);
  }
  const auto id = static_cast<std::uint32_t>(std::stoul(words.at(1)));
  const auto incarnation = std::stoull(words.at(2));
  if (verb == "interest") {
    distant::FrameWriter content;
    content.add(SubscriptionSpec{77, *Pattern::parse("a.**"), {}});
    auto bytes = content.take();
    rubicon_wire_Interest one{};
    one.subscriber = id;
    one.incarnation = incarnation;
    one.content._length = one.content._maximum = static_cast<std::uint32_t>(bytes.size());
    one.content._buffer = bytes.data();
    dds_write(interests_.get(), &one);
  } else {
    auto host = transport::host_id("host");
    std::string summary = "{}";
    rubicon_wire_Presence one{};
    one.id = id;
    one.incarnation = incarnation;
    one.version = kProtocolVersion;
    one.host = host.data();
    one.summary = summary.data();
    verb == "dispose" ? dds_dispose(presences_.get(), &one) : dds_write(presences_.get(), &one);
  }
}

/// Of starts of her own, with a summary of that size.
void Liar::presences(int count, std::size_t bytes) {
  auto host = transport::host_id("host");
  std::string summary(bytes, 'x');
  for (int i = 0; i < count; ++i) {
    rubicon_wire_Presence one{};
    one.id = own_;
    one.incarnation = static_cast<std::uint64_t>(i) + 1;
    one.version = kProtocolVersion;
    one.host = host.data();
    one.summary = summary.data();
    dds_write(presences_.get(), &one);
    dds_dispose(presences_.get(), &one);
    dds_unregister_instance(presences_.get(), &one);
  }
}

/// Writes lists of revoked certificates without a signature; each has at least `bytes` bytes.
void Liar::lists(int count, std::size_t bytes) {
  constexpr std::uint32_t kListSlot = 0xffffffff;
  for (int i = 0; i < count; ++i) {
    auto list = "junk " + std::to_string(i);
    list.resize(std::max(list.size(), bytes), ' ');
    rubicon_wire_Interest one{};
    one.subscriber = own_;
    one.incarnation = static_cast<std::uint64_t>(i) + 1;
    one.slot = kListSlot;
    one.content._length = one.content._maximum = static_cast<std::uint32_t>(list.size());
    one.content._buffer = reinterpret_cast<std::uint8_t*>(list.data());
    dds_write(interests_.get(), &one);
  }
}

void Liar::spy(const std::string& partition) {
  auto qos = make_qos();
  dds_qset_partition1(qos.get(), partition.c_str());
  subscriber_ = Entity(dds_create_subscriber(participant_.get(), qos.get(), nullptr));
  auto reliable = make_qos();
  dds_qset_reliability(reliable.get(), DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_history(reliable.get(), DDS_HISTORY_KEEP_ALL, 0);
  spy_ = Entity(dds_create_reader(subscriber_.get(), frame_topic_.get(), reliable.get(), nullptr));
  if (!spy_) std::cout << "refused" << std::endl;
}

void Liar::frame(const Words& words) {
  TupleSet change;
  change.tuple.key = words.at(5);
  change.tuple.value = words.at(6);
  change.tuple.media_type = "text/plain";
  change.tuple.sequence = 1'000'000;
  distant::FrameWriter content;
  content.add(change);
  send(words, std::stoull(words.at(4)), content.take());
}

void Liar::reply(const Words& words) {
  distant::FrameWriter content;
  content.add(Reply{OwnerId(static_cast<std::uint32_t>(std::stoul(words.at(4)))), std::stoull(words.at(6)),
                    Verdict::kRefused, ErrorCode::kRefused, "says mallory", 0});
  send(words, std::stoull(words.at(5)), content.take());
}

/// How many readers are matched with what she writes.
void Liar::readers() {
  dds_publication_matched_status_t presences{}, interests{};
  dds_get_publication_matched_status(presences_.get(), &presences);
  dds_get_publication_matched_status(interests_.get(), &interests);
  std::cout << "readers " << presences.current_count + interests.current_count << std::endl;
}

void Liar::send(const Words& words, std::uint64_t target_incarnation, Bytes bytes) {
  auto& [publisher, writer] = channels_[words.at(1)];
  if (!writer) {
    auto qos = make_qos();
    dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
    dds_qset_history(qos.get(), DDS_HISTORY_KEEP_ALL, 0);
    publisher = publisher_in(participant_, words.at(1));
    writer = Entity(dds_create_writer(publisher.get(), frame_topic_.get(), qos.get(), nullptr));
    if (!writer) return void(std::cout << "refused" << std::endl);
    await_reader(writer);
  }
  rubicon_wire_Frame one{};
  one.source = static_cast<std::uint32_t>(std::stoul(words.at(2)));
  one.source_incarnation = std::stoull(words.at(3));
  one.target_incarnation = target_incarnation;
  one.content._length = one.content._maximum = static_cast<std::uint32_t>(bytes.size());
  one.content._buffer = bytes.data();
  dds_write(writer.get(), &one);
}

}  // namespace rubicon::tuples::dds
