#include "tuples/dds/silent_participants.h"

#include <algorithm>

#include "tuples/dds/entity.h"
#include "tuples/dds/take_samples.h"
#include "tuples/dds/writers.h"

namespace rubicon::tuples::dds {

namespace {

GuidPrefix prefix_in(const dds_guid_t& guid) {
  GuidPrefix prefix{};
  std::copy_n(std::begin(guid.v), prefix.size(), prefix.begin());
  return prefix;
}

}  // namespace

std::set<GuidPrefix> participants_in_domain(dds_entity_t participant) {
  std::set<GuidPrefix> all;
  const auto reader = made(dds_create_reader(participant, DDS_BUILTIN_TOPIC_DCPSPARTICIPANT, nullptr, nullptr),
                           "reader of participants");
  if (!reader) return all;
  take<dds_builtintopic_participant_t>(reader->get(), SIZE_MAX, [&](const auto& sample, const auto& info) {
    if (info.instance_state == DDS_ALIVE_INSTANCE_STATE) all.insert(prefix_in(sample.key));
  });
  return all;
}

std::set<GuidPrefix> participants_matched(dds_entity_t reader) {
  std::set<GuidPrefix> all;
  for (const auto writer : matched_writers({reader})) {
    auto* endpoint = dds_get_matched_publication_data(reader, writer);
    if (!endpoint) continue;  // it went meanwhile
    all.insert(prefix_in(endpoint->participant_key));
    dds_builtintopic_free_endpoint(endpoint);
  }
  return all;
}

}  // namespace rubicon::tuples::dds
