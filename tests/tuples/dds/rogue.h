#pragma once

#include <dds/dds.h>

#include <chrono>
#include <string>

#include "base/bytes.h"
#include "transport/host_names.h"
#include "tuples/dds/dds_ecology.h"
#include "tuples/dds/dds_options.h"
#include "tuples/dds/entity.h"
#include "wire.h"

namespace rubicon::tuples::dds {

/// Somebody in domain 0 on loopback who says to be a component, of any version of the protocol, and tells others
/// whatever it likes.
class Rogue {
 public:
  explicit Rogue(std::uint32_t id, std::uint16_t version = kProtocolVersion, const DdsOptions& options = {})
      : Rogue(id, version, options,
              static_cast<std::uint64_t>(std::chrono::floor<std::chrono::microseconds>(std::chrono::system_clock::now())
                                             .time_since_epoch()
                                             .count())) {}

  Rogue(std::uint32_t id, std::uint16_t version, const DdsOptions& options, std::uint64_t incarnation) {
    domain_ = Entity(dds_create_domain(options.domain, domain_xml(options).c_str()));
    participant_ = Entity(dds_create_participant(options.domain, nullptr, nullptr));
    topic_ =
        Entity(dds_create_topic(participant_.get(), &rubicon_wire_Presence_desc, "rubicon_presence", nullptr, nullptr));
    auto qos = make_kept_qos();
    dds_qset_liveliness(qos.get(), DDS_LIVELINESS_AUTOMATIC, std::chrono::nanoseconds(options.lease).count());
    writer_ = Entity(dds_create_writer(participant_.get(), topic_.get(), qos.get(), nullptr));
    id_ = id;
    version_ = version;
    incarnation_ = incarnation;
    show(id, incarnation_);
  }

  /// Says to be this one as well, since then.
  void show(std::uint32_t id, std::uint64_t incarnation, const std::string& its_summary = {}) {
    std::string host = transport::host_id("host");
    std::string summary = its_summary.empty() ? R"({"host":"attic","program":"rogue 1.0"})" : its_summary;
    rubicon_wire_Presence presence{};
    presence.id = id;
    presence.incarnation = incarnation;
    presence.version = version_;
    presence.host = host.data();
    presence.summary = summary.data();
    dds_write(writer_.get(), &presence);
  }

  /// Says that this one, or another one, is gone.
  void end(std::uint32_t id, std::uint64_t incarnation) {
    std::string empty;
    rubicon_wire_Presence presence{};
    presence.id = id;
    presence.incarnation = incarnation;
    presence.host = presence.summary = empty.data();
    dds_dispose(writer_.get(), &presence);
    dds_unregister_instance(writer_.get(), &presence);
  }

  /// A writer of presence that has none to write.
  Entity silent_writer() const {
    return Entity(dds_create_writer(participant_.get(), topic_.get(), make_kept_qos().get(), nullptr));
  }

  /// Returns when all that it showed has arrived.
  void arrive() const { dds_wait_for_acks(writer_.get(), DDS_SECS(10)); }

  /// What the presence of a component says.
  struct Shown {
    std::uint64_t incarnation = 0;
    std::uint16_t version = 0;
  };
  /// Zeros if none shows itself to a reader in the partition within ten seconds. Version 1 reads in the default one.
  Shown shown_by(std::uint32_t id, const char* partition) {
    auto qos = make_qos();
    dds_qset_partition1(qos.get(), partition);
    const Entity subscriber(dds_create_subscriber(participant_.get(), qos.get(), nullptr));
    const Entity reader(dds_create_reader(subscriber.get(), topic_.get(), make_kept_qos().get(), nullptr));
    for (int i = 0; i < 1000; ++i, dds_sleepfor(DDS_MSECS(10))) {
      void* samples[1] = {};
      dds_sample_info_t infos[1];
      while (dds_take(reader.get(), samples, infos, 1, 1) == 1) {
        const auto& found = *static_cast<const rubicon_wire_Presence*>(samples[0]);
        const Shown shown{found.incarnation, found.version};
        const bool wanted = found.id == id && infos[0].valid_data;
        dds_return_loan(reader.get(), samples, 1);
        if (wanted) return shown;
      }
    }
    return {};
  }
  /// The start of a component, as its presence says; 0 if none shows itself within ten seconds.
  std::uint64_t incarnation_of(std::uint32_t id) { return shown_by(id, "*").incarnation; }

  /// Is no component any more. Returns when its last frames and its absence have arrived.
  void leave() {
    dds_wait_for_acks(frames_.get(), DDS_SECS(10));
    rubicon_wire_Presence presence{};
    std::string empty;
    presence.id = id_;
    presence.incarnation = incarnation_;
    presence.host = presence.summary = empty.data();
    dds_dispose(writer_.get(), &presence);
    dds_wait_for_acks(writer_.get(), DDS_SECS(10));
  }

  std::uint64_t incarnation() const { return incarnation_; }

  /// What stands in one of its interests.
  void interest(std::uint32_t slot, const Bytes& content) { interest_of(id_, incarnation_, slot, content); }
  /// In the name of another one.
  void interest_of(std::uint32_t id, std::uint64_t incarnation, std::uint32_t slot, const Bytes& content) {
    if (!interests_)
      interests_ = Entity(dds_create_writer(participant_.get(), interest_topic(), make_kept_qos().get(), nullptr));
    rubicon_wire_Interest one{};
    one.subscriber = id;
    one.incarnation = incarnation;
    one.slot = slot;
    one.content._length = one.content._maximum = static_cast<std::uint32_t>(content.size());
    one.content._buffer = const_cast<std::uint8_t*>(content.data());
    dds_write(interests_.get(), &one);
  }

  /// Ends a subscription of another one.
  void end_interest_of(std::uint32_t id, std::uint64_t incarnation, std::uint32_t slot, bool unregisters = false) {
    rubicon_wire_Interest one{};
    one.subscriber = id;
    one.incarnation = incarnation;
    one.slot = slot;
    dds_dispose(interests_.get(), &one);
    if (unregisters) dds_unregister_instance(interests_.get(), &one);
  }

  /// Whether a subscription of a component arrives within ten seconds. Takes all that are there.
  bool gets_subscription_of(std::uint32_t id) {
    if (!interest_reader_) {
      auto qos = make_qos();
      dds_qset_partition1(qos.get(), "*");
      subscriber_ = Entity(dds_create_subscriber(participant_.get(), qos.get(), nullptr));
      interest_reader_ = Entity(dds_create_reader(subscriber_.get(), interest_topic(), make_kept_qos().get(), nullptr));
    }
    bool found = take_subscriptions(id);
    for (int i = 0; i < 1000 && !found; ++i) {
      dds_sleepfor(DDS_MSECS(10));
      found = take_subscriptions(id);
    }
    dds_sleepfor(DDS_MSECS(10));
    take_subscriptions(id);
    return found;
  }

  /// A frame to `target`, by its own writer, that says to be from `source`.
  void frame(std::uint32_t source, std::uint64_t source_incarnation, std::uint32_t target,
             std::uint64_t target_incarnation, const Bytes& content) {
    if (!frames_) {
      frame_topic_ =
          Entity(dds_create_topic(participant_.get(), &rubicon_wire_Frame_desc, "rubicon_frames", nullptr, nullptr));
      auto partition = make_qos();
      dds_qset_partition1(partition.get(), (hex_id(OwnerId(id_)) + "." + hex_id(OwnerId(target))).c_str());
      publisher_ = Entity(dds_create_publisher(participant_.get(), partition.get(), nullptr));
      auto qos = make_qos();
      dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
      dds_qset_history(qos.get(), DDS_HISTORY_KEEP_ALL, 0);
      frames_ = Entity(dds_create_writer(publisher_.get(), frame_topic_.get(), qos.get(), nullptr));
      await_reader();
    }
    rubicon_wire_Frame frame{};
    frame.source = source;
    frame.source_incarnation = source_incarnation;
    frame.target_incarnation = target_incarnation;
    frame.content._length = frame.content._maximum = static_cast<std::uint32_t>(content.size());
    frame.content._buffer = const_cast<std::uint8_t*>(content.data());
    dds_write(frames_.get(), &frame);
  }

 private:
  dds_entity_t interest_topic() {
    if (!interest_topic_)
      interest_topic_ = Entity(
          dds_create_topic(participant_.get(), &rubicon_wire_Interest_desc, "rubicon_interests", nullptr, nullptr));
    return interest_topic_.get();
  }
  bool take_subscriptions(std::uint32_t id) {
    bool found = false;
    void* samples[1] = {};
    dds_sample_info_t infos[1];
    while (dds_take(interest_reader_.get(), samples, infos, 1, 1) == 1) {
      found |= infos[0].valid_data && static_cast<const rubicon_wire_Interest*>(samples[0])->subscriber == id;
      dds_return_loan(interest_reader_.get(), samples, 1);
    }
    return found;
  }
  /// What is written before somebody reads it is lost.
  void await_reader() const {
    dds_publication_matched_status_t status{};
    for (int i = 0; i < 1000 && status.current_count == 0; ++i) {
      dds_sleepfor(DDS_MSECS(1));
      dds_get_publication_matched_status(frames_.get(), &status);
    }
  }

  std::uint32_t id_ = 0;
  std::uint16_t version_ = 0;
  std::uint64_t incarnation_ = 0;
  // Deleted in the reverse order.
  Entity domain_, participant_, topic_, writer_, interest_topic_, interests_, subscriber_, interest_reader_,
      frame_topic_, publisher_, frames_;
};

}  // namespace rubicon::tuples::dds
