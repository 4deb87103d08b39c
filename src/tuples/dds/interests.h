#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>

#include "base/log.h"
#include "tuples/dds/link_entities.h"
#include "tuples/dds/presences.h"
#include "tuples/dds/reader_stores.h"

namespace rubicon::tuples::dds {

/// The subscriptions of the own component as others see them: each has a slot, which is an instance of its topic, and
/// is written when DDS accepts it.
class OwnInterests {
 public:
  void put(const SubscriptionSpec& spec);
  /// False: there is no such subscription.
  bool erase(std::uint32_t id);
  /// All are to be written again: owners send the snapshots again.
  void repeat();
  /// False: DDS accepts nothing at the moment.
  bool flush(dds_entity_t writer, const OwnStart& own);
  void clear() { *this = {}; }

 private:
  std::map<std::uint32_t, Bytes> slots_;            ///< contents; empty = no subscription
  std::map<std::uint32_t, std::uint32_t> slot_of_;  ///< by subscription id
  std::set<std::uint32_t> free_, unwritten_;
};

/// Who subscribes to what here: takes the interests of others from the wire, keeps them until their component is met,
/// and tells the listener of the link.
class Subscribers {
 public:
  /// All must outlive it.
  Subscribers(const OwnStart& own, const LinkShared& shared, LinkEntities& entities, Presences& presences,
              base::LimitedLog& log)
      : own_(own),
        shared_(shared),
        entities_(entities),
        presences_(presences),
        log_(log),
        interests_(presences.participants()) {}

  /// True: more may have arrived.
  bool take();
  /// The component is up: what it subscribed to before counts.
  void met(const Sender& sender);
  void shut_out(const Participant& who) { interests_.erase_all(who); }
  /// Drops those of participants that are neither matched nor up. An instance that two participants wrote does not end
  /// with one of them.
  void drop_gone();
  void clear();

 private:
  void on_interest(const InterestKey& key, const Participant& who, std::optional<SubscriptionSpec> spec);
  void note_end(InstanceQuota::Handle publication, InstanceQuota::Handle instance);

  const OwnStart& own_;
  const LinkShared& shared_;
  LinkEntities& entities_;
  Presences& presences_;
  base::LimitedLog& log_;
  Interests interests_;
  EndedInstances ended_;
};

}  // namespace rubicon::tuples::dds
