#pragma once

#include <array>
#include <compare>
#include <initializer_list>
#include <map>
#include <optional>
#include <set>

#include "rubicon/tuple.hpp"
#include "tuples/dds/entity.h"

namespace rubicon::tuples::dds {

/// The GUID of a DDS participant. DDS provides it: samples cannot forge it.
using Participant = std::array<std::uint8_t, 16>;

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
/// Those that have a writer which the reader is matched with.
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
