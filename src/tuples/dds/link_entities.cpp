#include "tuples/dds/link_entities.h"

#include <fmt/format.h>

#include <utility>

#include "wire.h"  // made from wire.idl

namespace rubicon::tuples::dds {

namespace {

/// Frames that DDS queues while the loop is busy; then their writers have to wait.
constexpr std::int32_t kQueuedFrames = 64;

}  // namespace

Result<void> LinkEntities::make() {
  if (presence_writer_ || !participant_) return {};
  auto done = make_topics();
  if (done) done = make_readers();
  if (done) done = make_writers();
  return done;
}

Result<void> LinkEntities::make_topics() {
  const auto make_one = [this](Entity& entity, const dds_topic_descriptor_t* type, const char* name) -> Result<void> {
    if (entity) return {};
    auto topic =
        made(dds_create_topic(participant_.get(), type, name, nullptr, nullptr), fmt::format("topic {}", name));
    if (!topic) return fail(std::move(topic.error()));
    entity = std::move(*topic);
    return {};
  };
  auto done = make_one(presence_topic_, &rubicon_wire_Presence_desc, "rubicon_presence");
  if (done) done = make_one(interest_topic_, &rubicon_wire_Interest_desc, "rubicon_interests");
  if (done) done = make_one(frame_topic_, &rubicon_wire_Frame_desc, "rubicon_frames");
  if (done && (!bound_presences(presence_topic_.get(), stores_->presence_quota) ||
               !bound_interests(interest_topic_.get(), stores_->interest_quota)))
    return fail(ErrorCode::kIo, "DDS does not bound what it keeps of others");
  return done;
}

Result<void> LinkEntities::make_readers() {
  auto frames = make_qos();
  dds_qset_reliability(frames.get(), DDS_RELIABILITY_RELIABLE, 0);
  dds_qset_history(frames.get(), DDS_HISTORY_KEEP_ALL, 0);
  dds_qset_resource_limits(frames.get(), kQueuedFrames, DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);
  auto of_frames = group_in("subscriber of frames", {fmt::format("*.{}", hex_id(self_))}, true);
  if (!of_frames) return fail(std::move(of_frames.error()));
  frame_subscriber_ = std::move(*of_frames);
  auto of_all = group_in("subscriber of presence and interests", {"*"}, true);
  if (!of_all) return fail(std::move(of_all.error()));
  all_subscriber_ = std::move(*of_all);
  // The readers request no lease: that would hide components with a longer one. Each component has its own.
  const auto make_one = [](Entity& entity, const char* what, dds_entity_t answer) -> Result<void> {
    auto reader = made(answer, fmt::format("reader of {}", what));
    if (!reader) return fail(std::move(reader.error()));
    entity = std::move(*reader);
    return {};
  };
  const auto make_kept = [&](Entity& entity, const char* what, const Entity& topic, Signal::Source source) {
    return make_one(
        entity, what,
        dds_create_reader(all_subscriber_.get(), topic.get(), make_kept_qos().get(), signal_.listener(source)));
  };
  auto done = make_one(
      frame_reader_, "frames",
      dds_create_reader(frame_subscriber_.get(), frame_topic_.get(), frames.get(), signal_.listener(Signal::kFrames)));
  if (done) done = make_kept(interest_reader_, "interests", interest_topic_, Signal::kInterests);
  if (done) done = make_kept(presence_reader_, "presence", presence_topic_, Signal::kPresence);
  return done;
}

/// A publisher or a subscriber.
Result<Entity> LinkEntities::group_in(const std::string& what, const std::vector<std::string>& partitions,
                                      bool of_readers) const {
  std::vector<const char*> names;
  for (const auto& one : partitions) names.push_back(one.c_str());
  auto qos = make_qos();
  dds_qset_partition(qos.get(), static_cast<std::uint32_t>(names.size()), names.data());
  return made(of_readers ? dds_create_subscriber(participant_.get(), qos.get(), nullptr)
                         : dds_create_publisher(participant_.get(), qos.get(), nullptr),
              what);
}

Result<void> LinkEntities::make_writers() {
  const auto make_one = [this](Entity& publisher, Entity& entity, const std::string& what, const Entity& topic,
                               const Qos& with, const std::vector<std::string>& partitions) -> Result<void> {
    auto group = group_in("publisher of " + what, partitions, false);
    if (!group) return fail(std::move(group.error()));
    auto writer = made(dds_create_writer(group->get(), topic.get(), with.get(), nullptr), "writer of " + what);
    if (!writer) return fail(std::move(writer.error()));
    publisher = std::move(*group);
    entity = std::move(*writer);
    return {};
  };
  const auto own = hex_id(self_);
  auto qos = make_kept_qos();
  dds_qset_writer_data_lifecycle(qos.get(), false);  // a crash must not look like an orderly leave
  auto done = make_one(interest_publisher_, interest_writer_, "interests", interest_topic_, qos, {own});
  if (!done) return done;
  dds_qset_liveliness(qos.get(), DDS_LIVELINESS_AUTOMATIC, lease_.count());
  // Components of version 1 read in the default partition only: they should see that another version is there.
  return make_one(presence_publisher_, presence_writer_, "presence", presence_topic_, qos, {own, ""});
}

Result<void> LinkEntities::make_in(Entity participant) {
  participant_ = std::move(participant);
  return make();
}

void LinkEntities::delete_readers_and_writers() {
  for (auto* entity : {&presence_reader_, &interest_reader_, &all_subscriber_, &frame_reader_, &frame_subscriber_,
                       &interest_writer_, &interest_publisher_, &presence_writer_, &presence_publisher_}) {
    entity->reset();
  }
}

void LinkEntities::delete_all() {
  delete_readers_and_writers();
  for (auto* entity : {&presence_topic_, &interest_topic_, &frame_topic_, &participant_}) entity->reset();
}

void LinkEntities::leave_behind(FormerDomain::Remains& remains) {
  remains.frame_readers.push_back(frame_reader_.get());
  for (auto* entity : {&presence_reader_, &interest_reader_, &all_subscriber_, &frame_reader_, &frame_subscriber_,
                       &interest_writer_, &interest_publisher_, &presence_writer_, &presence_publisher_,
                       &presence_topic_, &interest_topic_, &frame_topic_, &participant_})
    remains.entities.push_back(std::move(*entity));
  remains.used.push_back(std::exchange(stores_, std::make_shared<ReaderStores>()));
  remains.used.push_back(signal_.used());
}

}  // namespace rubicon::tuples::dds
