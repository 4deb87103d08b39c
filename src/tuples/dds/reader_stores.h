#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "tuples/dds/entity.h"
#include "tuples/link.h"

namespace rubicon::tuples::dds {

/// Limits what a reader keeps for one writer: the number of instances, and the bytes of values that were not taken yet.
/// DDS asks it as a filter of the topic, on its own threads, before it keeps a value. Of each instance it keeps the
/// last value. Thread-safe.
class InstanceQuota {
 public:
  using Handle = std::uint64_t;  ///< DDS handle of a writer or an instance

  static constexpr std::size_t kMaxWaitingBytes = 4UL << 20;

  explicit InstanceQuota(std::size_t most) : most_(most) {}
  InstanceQuota(const InstanceQuota&) = delete;
  InstanceQuota& operator=(const InstanceQuota&) = delete;

  /// A value of so many bytes arrives for an instance. False: a limit is reached.
  bool add(Handle writer, Handle instance, std::size_t bytes);
  /// The value was taken from the reader.
  void taken(Handle writer, Handle instance);
  /// The end of the instance was taken from the reader.
  void ended(Handle writer, Handle instance);
  /// Accepts no new values from this writer.
  void ban(Handle writer);
  /// Forgets all writers but these.
  void keep_only(const std::set<Handle>& there);

  std::size_t writers() const;

 private:
  struct Share {
    std::map<Handle, std::size_t> waiting;  ///< bytes, by instance
    std::size_t waiting_bytes = 0;
    bool banned = false;
  };

  std::size_t most_;
  mutable std::mutex mutex_;
  std::map<Handle, Share> shares_;  ///< by writer
};

/// The instances that a reader keeps though they ended, because their writer never unregisters them: a filter is not
/// asked about ends, and only another reader gives the memory back. A key has at most 20 bytes (wire.idl).
class EndedInstances {
 public:
  static constexpr std::size_t kMaxKept = 4096;

  /// The end of the instance was taken from the reader. False: it keeps more than half of kMaxKept of the last kMaxKept
  /// that ended, and nothing is added until clear().
  bool add(std::int32_t reader, InstanceQuota::Handle instance);
  void clear() {
    kept_.clear();
    over_ = false;
  }

 private:
  bool over_ = false;
  std::set<InstanceQuota::Handle> kept_;
};

/// Makes the quota the filter of a topic of that type. It outlives the topic. False: DDS refuses.
bool bound_presences(std::int32_t topic, InstanceQuota& quota);
bool bound_interests(std::int32_t topic, InstanceQuota& quota);

/// Accounts for the memory that each DDS participant makes this process use. A component has a participant of its own;
/// a participant with more than a few components is hostile, and is ignored for as long as it is present.
class Participants {
 public:
  static constexpr std::size_t kMaxComponents = 16;
  static constexpr std::size_t kMaxInterestBytes = 4UL << 20, kMaxInterestBytesOfAll = 64UL << 20;

  /// A component's start.
  using Start = std::pair<OwnerId, std::uint64_t>;

  bool is_banned(const Participant& who) const;
  /// False: the participant has kMaxComponents already.
  bool add(const Participant& who, const Start& start);
  void remove(const Participant& who, const Start& start);
  /// Returns the components of the participant, which are forgotten.
  std::vector<Start> ban(const Participant& who);
  /// The participant with most components; nullopt if none has more than one.
  std::optional<Participant> largest() const;

  /// False: the bound of bytes is reached.
  bool add_interest(const Participant& who, std::size_t bytes);
  void remove_interest(const Participant& who, std::size_t bytes);

  /// Ends the bans of all participants but these.
  void keep_only(const std::set<Participant>& there);
  void clear();

 private:
  struct Share {
    std::set<Start> starts;
    std::size_t interest_bytes = 0;
    bool banned = false;
    bool is_nothing() const { return starts.empty() && interest_bytes == 0 && !banned; }
  };
  void drop_if_nothing(const Participant& who);

  std::map<Participant, Share> shares_;
  std::size_t interest_bytes_ = 0;
};

/// Identifies an interest: a slot of one start of a component.
struct InterestKey {
  OwnerId subscriber{};
  std::uint64_t incarnation = 0;
  std::uint32_t slot = 0;
  friend auto operator<=>(const InterestKey&, const InterestKey&) = default;
};

/// The subscriptions of other components, including those whose presence has not arrived. Bounded per component, and in
/// bytes per participant and in all.
class Interests {
 public:
  static constexpr std::size_t kMaxOfOne = 10'000;

  explicit Interests(Participants& participants) : participants_(participants) {}

  const SubscriptionSpec* find(const InterestKey& key, const Participant& who) const;
  /// Replaces what the participant had in the slot; what another one has there stays, and counts if that one is the
  /// component. False: a bound is reached.
  bool put(const InterestKey& key, const Participant& who, SubscriptionSpec spec);
  void erase(const InterestKey& key, const Participant& who);
  /// The subscriptions of one start of a component, by slot, that this participant wrote.
  std::vector<SubscriptionSpec> of(OwnerId subscriber, std::uint64_t incarnation, const Participant& who) const;
  /// Removes the instances of a participant that is gone or banned.
  void erase_all(const Participant& who);
  /// The participants that have instances.
  std::set<Participant> participants() const;
  void clear() { all_.clear(); }

 private:
  using Start = std::tuple<OwnerId, std::uint64_t, Participant>;
  using Slots = std::map<std::uint32_t, SubscriptionSpec>;
  static Start start_of(const InterestKey& key, const Participant& who) {
    return {key.subscriber, key.incarnation, who};
  }

  Participants& participants_;
  std::map<Start, Slots> all_;
};

/// What the topics of presence and interests use, on the threads of DDS too: it has to live as long as they do.
struct ReaderStores {
  InstanceQuota presence_quota{2 * Participants::kMaxComponents}, interest_quota{Interests::kMaxOfOne};
};

}  // namespace rubicon::tuples::dds
