#pragma once

#include <dds/dds.h>

#include <chrono>
#include <string>

#include "tuples/dds/appearances.h"
#include "tuples/dds/dds_options.h"
#include "tuples/dds/entity.h"
#include "wire.h"

namespace rubicon::tuples::dds {

/// Somebody in domain 0 on loopback who says to be a component, of any version of the protocol, and does nothing else.
class Rogue {
 public:
  Rogue(std::uint32_t id, std::uint16_t version, const DdsOptions& options = {}) {
    domain_ = Entity(dds_create_domain(options.domain, domain_xml(options).c_str()));
    participant_ = Entity(dds_create_participant(options.domain, nullptr, nullptr));
    topic_ =
        Entity(dds_create_topic(participant_.get(), &rubicon_wire_Presence_desc, "rubicon_presence", nullptr, nullptr));
    auto qos = make_kept_qos();
    dds_qset_liveliness(qos.get(), DDS_LIVELINESS_AUTOMATIC, std::chrono::nanoseconds(options.lease).count());
    writer_ = Entity(dds_create_writer(participant_.get(), topic_.get(), qos.get(), nullptr));
    std::string host = "elsewhere", summary = R"({"host":"attic","program":"rogue 1.0"})";
    rubicon_wire_Presence presence{};
    presence.id = id;
    presence.incarnation = static_cast<std::uint64_t>(
        std::chrono::floor<std::chrono::microseconds>(std::chrono::system_clock::now()).time_since_epoch().count());
    presence.version = version;
    presence.host = host.data();
    presence.summary = summary.data();
    dds_write(writer_.get(), &presence);
  }

 private:
  Entity domain_, participant_, topic_, writer_;  ///< deleted in the reverse order
};

}  // namespace rubicon::tuples::dds
