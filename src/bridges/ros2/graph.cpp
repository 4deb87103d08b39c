#include "bridges/ros2/graph.h"

#include <algorithm>

#include "bridges/ros2/messages.h"
#include "bridges/ros2/names.h"
#include "ros_types.h"

namespace rubicon::bridges::ros2 {

namespace {

Guid guid_in(const dds_guid_t& guid) {
  Guid out{};
  std::copy(std::begin(guid.v), std::end(guid.v), out.begin());
  return out;
}

std::string user_data_of(const dds_qos_t* qos) {
  void* bytes = nullptr;
  std::size_t size = 0;
  if (qos == nullptr || !dds_qget_userdata(qos, &bytes, &size)) return {};
  std::string text(static_cast<const char*>(bytes), size);
  dds_free(bytes);
  return text;
}

/// `rt/`, `rq/`, `rr/`: what nodes make. ros_discovery_info and others do not tell a distribution.
bool is_of_ros(std::string_view topic) {
  return topic.starts_with("rt/") || topic.starts_with("rq/") || topic.starts_with("rr/");
}

}  // namespace

Gids gids_for(Distribution distribution, bool sees_hashes, bool sees_none) {
  switch (distribution) {
    case Distribution::kHumble: return Gids::k24;
    case Distribution::kJazzy: return Gids::k16;
    case Distribution::kNone: return Gids::kNone;
    case Distribution::kAuto: break;
  }
  if (sees_hashes == sees_none) return Gids::kNone;
  return sees_hashes ? Gids::k16 : Gids::k24;
}

std::optional<std::string_view> user_datum(std::string_view user_data, std::string_view key) {
  while (!user_data.empty()) {
    const auto entry = user_data.substr(0, user_data.find(';'));
    user_data.remove_prefix(std::min(entry.size() + 1, user_data.size()));
    if (entry.starts_with(key) && entry.size() > key.size() && entry[key.size()] == '=')
      return entry.substr(key.size() + 1);
  }
  return std::nullopt;
}

void Graph::take_participants(dds_entity_t reader) {
  tuples::dds::take<dds_builtintopic_participant_t>(reader, SIZE_MAX, [this](const auto& sample, const auto& info) {
    const auto guid = guid_in(sample.key);
    if (guid == us_) return;
    if (info.instance_state != DDS_IST_ALIVE) {
      participants_.erase(guid);
    } else if (info.valid_data && participants_.size() < kMaxSeen) {
      const auto text = user_data_of(sample.qos);
      auto& known = participants_[guid];
      known.is_ros = user_datum(text, "enclave").has_value();
      known.is_bridge = user_datum(text, "rubicon").has_value();
    }
  });
  changed_();
}

void Graph::take_publications(dds_entity_t reader) {
  take_endpoints(reader, true);
}

void Graph::take_subscriptions(dds_entity_t reader) {
  take_endpoints(reader, false);
}

void Graph::take_endpoints(dds_entity_t reader, bool are_writers) {
  bool changed = false, ours = false;
  auto& our_own = are_writers ? our_writers_ : our_readers_;
  tuples::dds::take<dds_builtintopic_endpoint_t>(reader, SIZE_MAX, [&](const auto& sample, const auto& info) {
    const auto guid = guid_in(sample.key);
    if (info.instance_state != DDS_IST_ALIVE) {
      ours |= our_own.erase(guid) != 0;
      changed |= are_writers && publications_.erase(guid) != 0;
    } else if (info.valid_data && guid_in(sample.participant_key) == us_) {
      ours |= is_of_ros(sample.topic_name) && our_own.insert(guid).second;
    } else if (info.valid_data) {
      see(sample, are_writers);
      changed = true;
    }
  });
  our_changes_ += ours ? 1 : 0;
  if (changed || ours) changed_();
}

void Graph::see(const dds_builtintopic_endpoint_t& endpoint, bool is_writer) {
  const auto from = participants_.find(guid_in(endpoint.participant_key));
  if (from != participants_.end() && is_of_ros(endpoint.topic_name)) {
    const bool has_hash = user_datum(user_data_of(endpoint.qos), "typehash").has_value();
    from->second.has_hash |= has_hash;
    from->second.has_none |= !has_hash;
  }
  if (!is_writer || publications_.size() >= kMaxSeen) return;
  auto topic = topic_of_dds(endpoint.topic_name);
  auto type = type_of_dds(endpoint.type_name);
  if (!topic || !type) return;
  Publication found{std::move(*topic), std::move(*type)};
  found.is_of_bridge = from != participants_.end() && from->second.is_bridge;
  dds_reliability_kind_t reliability{};
  dds_durability_kind_t durability{};
  dds_duration_t ignored = 0;
  found.reliable =
      dds_qget_reliability(endpoint.qos, &reliability, &ignored) && reliability == DDS_RELIABILITY_RELIABLE;
  found.kept = dds_qget_durability(endpoint.qos, &durability) && durability >= DDS_DURABILITY_TRANSIENT_LOCAL;
  publications_[guid_in(endpoint.key)] = std::move(found);
}

std::size_t Graph::robots() const {
  return static_cast<std::size_t>(std::count_if(participants_.begin(), participants_.end(), [](const auto& one) {
    return one.second.is_ros && !one.second.is_bridge;
  }));
}

/// An endpoint without a hash beside others with one is of a participant from Iron on.
bool Graph::sees_hashes() const {
  return std::any_of(participants_.begin(), participants_.end(),
                     [](const auto& one) { return one.second.is_ros && !one.second.is_bridge && one.second.has_hash; });
}

bool Graph::sees_none() const {
  return std::any_of(participants_.begin(), participants_.end(), [](const auto& one) {
    return one.second.is_ros && !one.second.is_bridge && one.second.has_none && !one.second.has_hash;
  });
}

namespace {

template <class Gid>
Gid gid_of(const Guid& guid) {
  Gid gid{};
  std::copy(guid.begin(), guid.end(), std::begin(gid.data));
  return gid;
}

template <class Gid>
std::vector<Gid> gids_of(const std::set<Guid>& guids) {
  std::vector<Gid> all;
  for (const auto& one : guids) all.push_back(gid_of<Gid>(one));
  return all;
}

/// Of one of the two forms of the message.
template <class Message, class Node, class Gid>
void write_info(dds_entity_t writer, const Guid& us, std::string name, const Graph& graph) {
  auto readers = gids_of<Gid>(graph.our_readers()), writers = gids_of<Gid>(graph.our_writers());
  std::vector<Node> nodes(1);
  nodes[0].node_namespace[0] = '/';
  name.copy(nodes[0].node_name, sizeof nodes[0].node_name - 1);
  lend(nodes[0].reader_gid_seq, readers);
  lend(nodes[0].writer_gid_seq, writers);
  Message message{};
  message.gid = gid_of<Gid>(us);
  lend(message.node_entities_info_seq, nodes);
  dds_write(writer, &message);
}

}  // namespace

const dds_topic_descriptor_t& discovery_info_descriptor(Gids gids) {
  static const dds_topic_descriptor_t kNew = rmw_dds_common_msg_dds__ParticipantEntitiesInfo__desc;
  static const dds_topic_descriptor_t kOld = [] {
    const auto& from = rmw_dds_common_msg_dds__humble_ParticipantEntitiesInfo__desc;
    return dds_topic_descriptor_t{from.m_size,           from.m_align,      from.m_flagset,
                                  from.m_nkeys,          kNew.m_typename,   from.m_keys,
                                  from.m_nops,           from.m_ops,        from.m_meta,
                                  from.type_information, from.type_mapping, from.restrict_data_representation};
  }();
  return gids == Gids::k16 ? kNew : kOld;
}

void write_discovery_info(dds_entity_t writer, Gids gids, const Guid& us, const std::string& node, const Graph& graph) {
  if (gids == Gids::k16)
    write_info<rmw_dds_common_msg_dds__ParticipantEntitiesInfo_, rmw_dds_common_msg_dds__NodeEntitiesInfo_,
               rmw_dds_common_msg_dds__Gid_>(writer, us, node, graph);
  else
    write_info<rmw_dds_common_msg_dds__humble_ParticipantEntitiesInfo_,
               rmw_dds_common_msg_dds__humble_NodeEntitiesInfo_, rmw_dds_common_msg_dds__humble_Gid_>(writer, us, node,
                                                                                                      graph);
}

}  // namespace rubicon::bridges::ros2
