#include "tuples/dds/entity.h"

#include <fmt/format.h>

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

}  // namespace rubicon::tuples::dds
