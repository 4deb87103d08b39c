#include "tuples/dds/entity.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <vector>

#include "base/text.h"

namespace rubicon::tuples::dds {

Entity& Entity::operator=(Entity&& other) noexcept {
  if (this != &other) {
    reset();
    entity_ = std::exchange(other.entity_, 0);
  }
  return *this;
}

void Entity::reset() {
  if (entity_ > 0) dds_delete(entity_);
  entity_ = 0;
}

Result<Entity> made(dds_entity_t answer, const std::string& what) {
  if (answer > 0) return Entity(answer);
  return fail(ErrorCode::kIo, fmt::format("DDS: {} cannot be made: {}", what, dds_strretcode(-answer)));
}

Qos make_kept_qos() {
  auto qos = make_qos();
  dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, 0);
  dds_qset_durability(qos.get(), DDS_DURABILITY_TRANSIENT_LOCAL);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, 1);
  return qos;
}

namespace {

/// The id whose hex_id() this is.
std::optional<OwnerId> id_of(std::string_view hex) {
  const auto id = base::parse_hex_number<std::uint32_t>(hex);
  if (!id || hex_id(OwnerId(*id)) != hex) return std::nullopt;
  return OwnerId(*id);
}

/// From the partition of a channel, which is called `<source>.<target>`.
std::optional<OwnerId> source_of(const dds_qos_t* qos) {
  std::uint32_t count = 0;
  char** names = nullptr;
  std::optional<OwnerId> source;
  if (dds_qget_partition(qos, &count, &names) && count == 1) {
    const std::string_view name = names[0];
    const auto dot = name.find('.');
    if (dot != name.npos) source = id_of(name.substr(0, dot));
  }
  for (std::uint32_t i = 0; i < count; ++i) dds_free(names[i]);
  dds_free(names);
  return source;
}

std::set<dds_instance_handle_t> matched(dds_entity_t reader) {
  std::vector<dds_instance_handle_t> all(256);
  while (true) {
    const auto count = dds_get_matched_publications(reader, all.data(), all.size());
    if (count < 0) return {};
    if (static_cast<std::size_t>(count) <= all.size()) return {all.begin(), all.begin() + count};
    all.resize(2 * static_cast<std::size_t>(count));
  }
}

Participant guid_of(const dds_guid_t& guid) {
  Participant participant{};
  std::copy(std::begin(guid.v), std::end(guid.v), participant.begin());
  return participant;
}

}  // namespace

std::string hex_id(OwnerId id) {
  return fmt::format("{:08x}", number(id));
}

Participant participant_of(dds_entity_t participant) {
  dds_guid_t guid{};
  return dds_get_guid(participant, &guid) == DDS_RETCODE_OK ? guid_of(guid) : Participant{};
}

std::set<Participant> participants_in_domain(dds_entity_t participant) {
  std::set<Participant> all;
  const auto reader = made(dds_create_reader(participant, DDS_BUILTIN_TOPIC_DCPSPARTICIPANT, nullptr, nullptr),
                           "reader of participants");
  if (!reader) return all;
  take<dds_builtintopic_participant_t>(reader->get(), SIZE_MAX, [&](const auto& sample, const auto& info) {
    if (info.instance_state == DDS_ALIVE_INSTANCE_STATE) all.insert(guid_of(sample.key));
  });
  return all;
}

std::set<Participant> participants_matched(dds_entity_t reader) {
  std::set<Participant> all;
  for (const auto writer : matched_writers({reader})) {
    auto* endpoint = dds_get_matched_publication_data(reader, writer);
    if (!endpoint) continue;  // it went meanwhile
    all.insert(guid_of(endpoint->participant_key));
    dds_builtintopic_free_endpoint(endpoint);
  }
  return all;
}

std::set<dds_instance_handle_t> matched_writers(std::initializer_list<dds_entity_t> readers) {
  std::set<dds_instance_handle_t> there;
  for (const auto reader : readers) there.merge(matched(reader));
  return there;
}

const Writer* Writers::find(dds_entity_t reader, dds_instance_handle_t publication) {
  if (const auto known = known_.find(publication); known != known_.end()) return &known->second;
  auto* endpoint = dds_get_matched_publication_data(reader, publication);
  if (!endpoint) return nullptr;
  Writer writer;
  writer.participant = guid_of(endpoint->participant_key);
  writer.source = source_of(endpoint->qos);
  dds_builtintopic_free_endpoint(endpoint);
  return &known_.emplace(publication, writer).first->second;
}

std::set<Participant> Writers::keep_only(const std::set<dds_instance_handle_t>& there) {
  std::erase_if(known_, [&there](const auto& one) { return !there.contains(one.first); });
  long_ = 2 * known_.size() + kFew;
  std::set<Participant> remaining;
  for (const auto& one : known_) remaining.insert(one.second.participant);
  return remaining;
}

}  // namespace rubicon::tuples::dds
