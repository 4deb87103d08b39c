#pragma once

#include <dds/dds.h>

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "rubicon/result.hpp"
#include "rubicon/tuple.hpp"

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

/// The GUID of a DDS participant. DDS provides it: samples cannot forge it.
using Participant = std::array<std::uint8_t, 16>;

/// A start of a component, and the participant that shows it.
struct Sender {
  OwnerId id{};
  std::uint64_t incarnation = 0;
  Participant participant{};
  friend bool operator==(const Sender&, const Sender&) = default;
};

/// The origin of a DDS writer.
struct Writer {
  Participant participant{};
  std::optional<OwnerId> source;  ///< component of the writer of frames, from its partition
};

/// An id as the names of partitions have it: `01a00001`.
std::string hex_id(OwnerId id);

/// The GUID of a participant of this process; zeros: it has none.
Participant participant_of(dds_entity_t participant);
/// The participants of the domain that DDS knows, those of this process too.
std::set<Participant> participants_in_domain(dds_entity_t participant);
/// The participants that have a writer matched with the reader.
std::set<Participant> participants_matched(dds_entity_t reader);

/// The writers that are matched with any of the readers.
std::set<dds_instance_handle_t> matched_writers(std::initializer_list<dds_entity_t> readers);

/// Origins of the writers of samples, cached because asking DDS is slow.
class Writers {
 public:
  /// nullptr: the writer is gone, and its origin was not asked before.
  const Writer* find(dds_entity_t reader, dds_instance_handle_t publication);
  /// Whether a sample of it was read.
  bool knows(dds_instance_handle_t publication) const { return known_.contains(publication); }
  /// Time to call keep_only(): many were added since the last call.
  bool is_long() const { return known_.size() >= long_; }
  /// Drops all others; returns the participants that remain.
  std::set<Participant> keep_only(const std::set<dds_instance_handle_t>& there);
  void clear() { known_.clear(); }

 private:
  static constexpr std::size_t kFew = 64;

  std::map<dds_instance_handle_t, Writer> known_;
  std::size_t long_ = kFew;
};

}  // namespace rubicon::tuples::dds
