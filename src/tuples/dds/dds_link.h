#pragma once

#include <map>
#include <optional>
#include <set>

#include "base/deadline.h"
#include "base/lifetime.h"
#include "base/limited_log.h"
#include "base/paced_call.h"
#include "tuples/dds/dds_ecology.h"
#include "tuples/dds/early.h"
#include "tuples/dds/former_domain.h"
#include "tuples/dds/id_conflicts.h"
#include "tuples/dds/instance_quota.h"
#include "tuples/dds/interests.h"
#include "tuples/dds/patience.h"
#include "tuples/dds/peer.h"
#include "tuples/dds/reader_stores.h"
#include "tuples/dds/signal.h"
#include "tuples/peer_policy.h"

namespace rubicon::tuples::dds {

/// The link of one component over DDS (docs/ecology.md): publishes its presence and its subscriptions, and has a
/// channel to each component to which it sends.
class DdsLink final : public Link, private distant::FrameReader {
 public:
  /// What the links of a process share; it outlives them.
  struct Shared {
    DdsOptions options;
    Scheduler& scheduler;
    DdsEcology::Post post;
    base::LogSink& log;
    std::function<Duration()> since_boot = base::since_boot;
    std::shared_ptr<ComponentStarts> starts = std::make_shared<ComponentStarts>();
    std::set<DdsLink*> links = {};  ///< all of them
    Patience patience = {};         ///< of links that leave
  };

  /// Makes its DDS entities; kIo names the one that cannot be made. `displaced` is called if another process uses the
  /// id, and used it before.
  /// An empty host is that of this machine.
  static Result<std::unique_ptr<DdsLink>> make(StandIn who, Entity participant, Shared& shared);
  ~DdsLink() override;

  /// Whether a writer of a presence is matched that has brought none yet.
  bool expects_presence() const;
  /// Those that have a component as far as this link sees, its own one too.
  std::set<Participant> participants_with_components() const;
  dds_entity_t participant() const { return participant_.get(); }

  // -- other addresses (dds_link_moves.cpp)
  /// Leaves the domain as suspend() does, but only takes out what is to be deleted with it.
  void leave_behind(FormerDomain::Remains& remains);

  // -- another participant for the same component (dds_link_renewal.cpp)
  OwnerId id() const { return self_; }
  /// Leaves the domain, with all DDS entities. The listener sees that all others are lost; what it asks for meanwhile
  /// is kept.
  void suspend();
  /// Enters with a participant of a domain that was made again. Subscriptions and own tuples are as before; for others
  /// it is a component that was lost for a moment.
  Result<void> resume(Entity participant);

  void attach(LinkListener& listener, std::uint64_t incarnation) override;
  void detach() override { leave(); }
  bool publish(OwnerId subscriber, std::span<const Change> changes) override;
  void subscribe(const SubscriptionSpec& spec) override;
  void unsubscribe(std::uint32_t id) override;
  Result<void> remote_set(const RemoteSet& set) override;
  void reply(const Reply& reply) override;
  std::vector<OwnerId> peers() const override;
  void describe(std::string summary) override;
  PeerPolicy& policy() override { return *policy_; }

 private:
  DdsLink(StandIn who, Entity participant, Shared& shared);

  // FrameReader: the entries of the present frame; on_set() and what follows in dds_link_sets.cpp
  void on_changes(std::span<const Change> changes) override;
  void on_set(RemoteSet&& set) override;
  void on_reply(Reply&& reply) override;
  void on_times(const distant::FrameTimes& times) override;
  void on_identity_check(const distant::IdentityCheck&) override {}  // between processes with one id only

  Result<void> make_entities();
  Result<void> make_topics();
  Result<void> make_readers();
  Result<void> make_writers();
  Result<Entity> group_in(const std::string& what, const std::vector<std::string>& partitions, bool of_readers) const;
  void leave();
  void delete_entities();
  void forget_others();
  void forget_own();
  void drain(unsigned sources);

  // -- presence (dds_link_presence.cpp)
  /// A sample of a component's presence.
  struct PresenceNews {
    Participants::Start who;
    bool there = false, left = false;
    std::uint16_t version = 0;  ///< this and the rest: only if it is present
    Peer::Start start;          ///< of an absence the publication only
  };
  /// At most about kSamples; true: more may be waiting.
  bool take_presences();
  bool may_end(const PresenceNews& news) const;
  bool accepts(const PresenceNews& news);
  void on_presence(const PresenceNews& news);
  PeerIdentity identity_of(OwnerId id, std::uint64_t incarnation, const Peer::Start& start) const;
  void add_start(Peer& peer, const PresenceNews& news);
  Peer::Starts::iterator excess_start(Peer& peer, std::uint64_t newcomer);
  void remove_start(OwnerId id, Peer& peer, Peer::Starts::iterator start);
  void on_absence(const PresenceNews& news);
  void end_start(const Participants::Start& who, bool left);
  void end_unmatched();
  void ban(const Participant& who);
  void shut_out(const Participant& who);
  Peer* find_or_add_peer(OwnerId id);
  void evict_peers();
  void drop_gone_peers();
  void forget_gone_peers();
  void select_incarnation(OwnerId id, Peer& peer, bool left);
  void report_summary(OwnerId id, Peer& peer);
  void peer_up(OwnerId id, Peer& peer, std::uint64_t incarnation);
  void peer_down(OwnerId id, Peer& peer, PeerEvent event);
  void drop_gone_writers();

  // -- interests and frames (dds_link_reading.cpp)
  /// The same.
  bool take_interests();
  void on_interest(const InterestKey& key, const Participant& who, std::optional<SubscriptionSpec> spec);
  bool take_frames();
  void on_frame(const EarlyFrames::Sender& sender, ByteView content);
  void buffer(const EarlyFrames::Sender& sender, ByteView content);
  void drop_expired_frames();
  void deliver(OwnerId id, ByteView content);

  // -- other addresses (dds_link_moves.cpp)
  void drop_interests_of_gone();
  void await_receivers();

  // -- remote sets of others (dds_link_sets.cpp)
  void take_set(Peer& peer, EarlySets::One&& one);
  bool is_early(const Peer& peer, const EarlySets::One& one);
  bool waits_for_times(const Peer& peer, const EarlySets::One& one) const;
  void hold_early(Peer& peer, EarlySets::One&& one);
  void take_early_after(Duration pause);
  void take_early();
  Duration left_of(const Peer& peer, const EarlySets::One& one) const;
  void send_times(OwnerId id, Peer& peer, bool asks);

  // -- another participant (dds_link_renewal.cpp)
  void correct_start();
  void delete_while_reading(const std::function<void()>& remove) const;

  Channel* channel_to(OwnerId id, Peer& peer);
  Peer* find_up(OwnerId id);
  void retry_flush();
  void flush();
  void flush(Peer& peer);
  Channel::State write_frames(Peer& peer);
  bool flush_slots();
  /// All owners send the snapshots of all subscriptions again.
  void repeat_interests();
  bool write_slot(std::uint32_t number, const Bytes& content);
  bool write_presence();
  void warn(const std::string& subject, const std::string& text) { limited_log_.warning(subject, text); }

  OwnerId self_;
  Shared& shared_;
  Scheduler& scheduler_;
  Log log_;
  base::LimitedLog limited_log_;
  Duration lease_;
  std::string host_;
  std::unique_ptr<PeerPolicy> policy_;
  std::shared_ptr<ComponentStarts> starts_;
  std::string summary_;
  bool presence_unwritten_ = false;
  Signal signal_;
  std::shared_ptr<ReaderStores> stores_ = std::make_shared<ReaderStores>();
  Entity participant_, presence_topic_, interest_topic_, frame_topic_;
  Entity all_subscriber_, presence_reader_, interest_reader_, frame_subscriber_, frame_reader_;
  Entity presence_publisher_, presence_writer_, interest_publisher_, interest_writer_;
  LinkListener* listener_ = nullptr;
  std::uint64_t incarnation_ = 0;
  std::map<OwnerId, Peer> peers_;
  std::uint64_t starts_seen_ = 0;
  std::uint32_t unmatched_seen_ = 0;                ///< of the publications of presence
  std::map<std::uint32_t, Bytes> slots_;            ///< contents; empty = no subscription
  std::map<std::uint32_t, std::uint32_t> slot_of_;  ///< by subscription id
  std::set<std::uint32_t> free_slots_, unwritten_slots_;
  std::deque<OwnerId> gone_;  ///< of peers_, in the order in which they went down
  Writers writers_;
  Participants participants_;
  Interests interests_{participants_};
  EarlyFrames early_frames_;
  EarlySets early_sets_;
  Timer early_timer_, early_sets_timer_;
  IdConflicts id_conflicts_;
  OwnerId reading_from_{};
  std::optional<Duration> reading_sent_;  ///< when the present frame was sent, by the clock of its sender
  base::OncePerTurn flush_soon_{scheduler_, [this] { flush(); }};  ///< so that the changes of a turn are sent together
  /// Paced, because somebody who comes and goes would make all owners send all they have.
  base::PacedCall repeat_soon_{scheduler_, std::chrono::seconds(1), [this] { repeat_interests(); }};
  base::Deadline flush_retry_{scheduler_, [this] { flush(); }};
};

}  // namespace rubicon::tuples::dds
