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

/// A DDS participant, as DDS itself names it: one end of the ecology, whatever its samples say.
using Participant = std::array<std::uint8_t, 16>;

/// Whose a writer is.
struct Writer {
  Participant participant{};
  std::optional<OwnerId> source;  ///< the first part of its partition, which only its owner may have
};

/// The writers that any of the readers is matched with.
std::set<dds_instance_handle_t> matched_writers(std::initializer_list<dds_entity_t> readers);

/// The writers of samples, asked of DDS once each; those that are gone are forgotten.
class Writers {
 public:
  /// nullptr: it went before this was asked, whose it was cannot be known any more.
  const Writer* find(dds_entity_t reader, dds_instance_handle_t publication);
  /// Time to call keep_only(): much was added since the last time.
  bool is_long() const { return known_.size() >= long_; }
  /// Drops all but these; the participants that remain.
  std::set<Participant> keep_only(const std::set<dds_instance_handle_t>& there);
  void clear() { known_.clear(); }

 private:
  static constexpr std::size_t kFew = 64;

  std::map<dds_instance_handle_t, Writer> known_;
  std::size_t long_ = kFew;
};

}  // namespace rubicon::tuples::dds
