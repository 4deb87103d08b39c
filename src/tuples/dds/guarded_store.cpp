#include "tuples/dds/guarded_store.h"

#include <dds/ddsi/ddsi_serdata.h>
#include <dds/ddsi/ddsi_tkmap.h>
#include <dds/ddsi/q_protocol.h>

#include <cstddef>
#include <cstring>
#include <type_traits>

#include "wire.h"

/// The default store of a reader. The library exports it, but no installed header declares it (0.10.2:
/// src/core/ddsc/src/dds__rhc_default.h).
extern "C" dds_rhc* dds_rhc_default_new(dds_reader* reader, const ddsi_sertype* type);

namespace rubicon::tuples::dds {

namespace {

static_assert(std::is_standard_layout_v<GuardedStore::Face>);

GuardedStore::Face& face_of(dds_rhc* head) {
  return *reinterpret_cast<GuardedStore::Face*>(head);
}
GuardedStore::Face& face_of(ddsi_rhc* head) {
  return *reinterpret_cast<GuardedStore::Face*>(head);
}

/// In the order of the wire.
GuidPrefix prefix_of(const ddsi_guid_t& guid) {
  GuidPrefix prefix{};
  auto* to = prefix.data();
  for (const auto word : guid.prefix.u) {
    for (int shift = 24; shift >= 0; shift -= 8) *to++ = static_cast<std::uint8_t>(word >> shift);
  }
  return prefix;
}

/// What the sample says to be, as the reader will see it: the first field of its key.
OwnerId claimed_id(const ddsi_serdata* sample, const ddsi_tkmap_instance* key) {
  static_assert(offsetof(rubicon_wire_Presence, id) == 0 && offsetof(rubicon_wire_Interest, subscriber) == 0);
  union {
    rubicon_wire_Presence presence;
    rubicon_wire_Interest interest;
    std::uint32_t id;
  } fields;
  std::memset(&fields, 0, sizeof(fields));
  const bool known = ddsi_serdata_untyped_to_sample(sample->type, key->m_sample, &fields, nullptr, nullptr);
  return known ? OwnerId(fields.id) : model::kNoOwner;
}

bool store_sample(ddsi_rhc* head, const ddsi_writer_info* writer, ddsi_serdata* sample, ddsi_tkmap_instance* key) {
  auto& face = face_of(head);
  if (face.claims && face.claims->are_checked() &&
      !face.claims->may_use(prefix_of(writer->guid), claimed_id(sample, key)))
    return true;
  const auto& prefix = writer->guid.prefix.u;
  const bool is_value = sample->kind == SDK_DATA;
  const bool may = is_value ? face.quota->add({writer->iid, {prefix[0], prefix[1], prefix[2]}}, key->m_iid,
                                              ddsi_serdata_size(sample))
                            : face.quota->has(writer->iid, key->m_iid);
  if (!may) return true;  // false would make Cyclone retry and delay all others
  const bool stored = dds_rhc_store(face.store, writer, sample, key);
  if (stored && (sample->statusinfo & NN_STATUSINFO_UNREGISTER) != 0) face.quota->unregistered(writer->iid, key->m_iid);
  return stored;
}

void writer_gone(ddsi_rhc* head, const ddsi_writer_info* writer) {
  dds_rhc_unregister_wr(face_of(head).store, writer);
  face_of(head).quota->gone(writer->iid);
}

dds_return_t begin_store(dds_rhc* head, dds_reader* reader, const ddsi_sertype* type, ddsi_tkmap* keys) {
  auto& face = face_of(head);
  face.quota->clear();
  face.store = dds_rhc_default_new(reader, type);
  return dds_rhc_associate(face.store, reader, type, keys);
}

void end_store(ddsi_rhc* head) {
  dds_rhc_free(face_of(head).store);
}

template <auto Member, class... Arguments>
auto pass_on(dds_rhc* head, Arguments... arguments) {
  auto* store = face_of(head).store;
  return (store->common.ops->*Member)(store, arguments...);
}

const dds_rhc_ops kOperations = {
    {store_sample, writer_gone,
     [](ddsi_rhc* head, const std::uint64_t writer) { dds_rhc_relinquish_ownership(face_of(head).store, writer); },
     [](ddsi_rhc* head, const dds_qos_t* qos) { dds_rhc_set_qos(face_of(head).store, qos); }, end_store},
    pass_on<&dds_rhc_ops::read>,
    pass_on<&dds_rhc_ops::take>,
    pass_on<&dds_rhc_ops::readcdr>,
    pass_on<&dds_rhc_ops::takecdr>,
    pass_on<&dds_rhc_ops::add_readcondition>,
    pass_on<&dds_rhc_ops::remove_readcondition>,
    pass_on<&dds_rhc_ops::lock_samples>,
    begin_store};

}  // namespace

GuardedStore::GuardedStore(InstanceQuota& quota, Claims* claims) : face_{{}, nullptr, &quota, claims} {
  face_.head.common.ops = &kOperations;
}

dds_entity_t GuardedStore::make_reader(dds_entity_t parent, dds_entity_t topic, const dds_qos_t* qos,
                                       const dds_listener_t* listener) {
  return dds_create_reader_rhc(parent, topic, qos, listener, &face_.head);
}

}  // namespace rubicon::tuples::dds
