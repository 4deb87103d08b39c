#pragma once

#include <dds/dds.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "rubicon/result.hpp"

namespace rubicon::tuples::dds {

/// Owns a DDS entity: deletes it and its children. After that no listener of it runs.
class Entity {
 public:
  Entity() = default;
  explicit Entity(dds_entity_t entity) : entity_(entity) {}
  Entity(Entity&& other) noexcept : entity_(std::exchange(other.entity_, 0)) {}
  Entity& operator=(Entity&& other) noexcept;
  Entity(const Entity&) = delete;
  Entity& operator=(const Entity&) = delete;
  ~Entity() { reset(); }

  void reset();
  dds_entity_t get() const { return entity_; }
  explicit operator bool() const { return entity_ > 0; }

 private:
  dds_entity_t entity_ = 0;
};

/// Wraps the result of a dds_create_... call; kIo with `what` and the reason from DDS.
Result<Entity> made(dds_entity_t answer, const std::string& what);

struct QosDeleter {
  void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};
using Qos = std::unique_ptr<dds_qos_t, QosDeleter>;
inline Qos make_qos() {
  return Qos(dds_create_qos());
}

/// For topics whose last sample of each instance is delivered to late joiners. Writing never blocks.
Qos make_kept_qos();

struct ListenerDeleter {
  void operator()(dds_listener_t* listener) const { dds_delete_listener(listener); }
};
using DdsListener = std::unique_ptr<dds_listener_t, ListenerDeleter>;

/// Samples taken at a time, and frames processed in one turn of the loop.
inline constexpr std::uint32_t kSamples = 64;

/// Takes all samples of the reader, but not many more than `max`, and visits each, valid or not. Returns their number.
template <class Sample, class Visit>
std::size_t take(dds_entity_t reader, std::size_t max, Visit visit) {
  void* samples[kSamples] = {};
  dds_sample_info_t infos[kSamples];
  std::size_t total = 0;
  while (total < max) {
    const auto count = dds_take(reader, samples, infos, kSamples, kSamples);
    if (count <= 0) break;
    for (int i = 0; i < count; ++i) visit(*static_cast<const Sample*>(samples[i]), infos[i]);
    dds_return_loan(reader, samples, count);
    total += static_cast<std::size_t>(count);
  }
  return total;
}

}  // namespace rubicon::tuples::dds
