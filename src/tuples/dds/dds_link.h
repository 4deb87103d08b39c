#pragma once

#include <map>
#include <optional>
#include <set>

#include "base/deadline.h"
#include "base/lifetime.h"
#include "base/limited_log.h"
#include "tuples/dds/dds_ecology.h"
#include "tuples/dds/early_frames.h"
#include "tuples/dds/guarded_store.h"
#include "tuples/dds/id_conflicts.h"
#include "tuples/dds/interests.h"
#include "tuples/dds/peer.h"
#include "tuples/dds/signal.h"
#include "tuples/host_policy.h"

namespace rubicon::tuples::dds {

/// The link of one component over DDS (docs/ecology.md): publishes its presence and its subscriptions, and has a
/// channel to each component to which it sends.
class DdsLink final : public Link, private FrameReader {
 public:
  /// Makes its DDS entities; kIo names the one that cannot be made. `displaced` is called if another process uses the
  /// id, and used it before.
  /// An empty host is that of this machine.
  static Result<std::unique_ptr<DdsLink>> make(StandIn who, Entity participant, const DdsOptions& options,
                                               Scheduler& scheduler, DdsEcology::Post post,
                                               std::shared_ptr<ComponentStarts> starts, base::LogSink& log);
  ~DdsLink() override;

  void attach(LinkListener& listener, std::uint64_t incarnation) override;
  void detach() override { leave(); }
  bool publish(OwnerId subscriber, std::span<const Change> changes) override;
  void subscribe(const SubscriptionSpec& spec) override;
  void unsubscribe(std::uint32_t id) override;
  Result<void> remote_set(const RemoteSet& set) override;
  void reply(const Reply& reply) override;
  std::vector<OwnerId> peers() const override;
  void describe(std::string summary) override;
  PeerPolicy& policy() override { return policy_; }

 private:
  DdsLink(StandIn who, Entity participant, const DdsOptions& options, Scheduler& scheduler, DdsEcology::Post post,
          std::shared_ptr<ComponentStarts> starts, base::LogSink& log);

  // FrameReader: the entries of the present frame
  void on_changes(std::span<const Change> changes) override;
  void on_set(RemoteSet&& set) override;
  void on_reply(Reply&& reply) override;
  void on_identity_check(const IdentityCheck&) override {}  // between processes with one id only

  Result<void> make_entities();
  Result<void> make_topics();
  Result<void> make_readers();
  Result<void> make_writers();
  void leave();
  void forget_all();
  void drain(unsigned sources);

  // -- presence (dds_link_presence.cpp)
  /// A sample of a component's presence.
  struct PresenceNews {
    Participants::Start who;
    dds_instance_handle_t publication = 0;
    bool there = false, left = false;
    std::uint16_t version = 0;  ///< this and the rest: only if it is present
    Peer::Start start;
  };
  void take_presences();
  bool accepts(const PresenceNews& news);
  void on_presence(const PresenceNews& news);
  void add_start(Peer& peer, const PresenceNews& news);
  Peer::Starts::iterator excess_start(Peer& peer, std::uint64_t newcomer);
  void remove_start(OwnerId id, Peer& peer, Peer::Starts::iterator start);
  void on_absence(const Participants::Start& who, bool left);
  void ban(const Participant& who);
  Peer* find_or_add_peer(OwnerId id);
  void evict_peers();
  void drop_gone_peers();
  void select_incarnation(OwnerId id, Peer& peer, bool left);
  void report_summary(OwnerId id, Peer& peer);
  void peer_up(OwnerId id, Peer& peer, std::uint64_t incarnation);
  void peer_down(OwnerId id, Peer& peer, PeerEvent event);
  void drop_gone_writers();

  // -- interests and frames (dds_link_reading.cpp)
  void take_interests();
  void on_interest(const InterestKey& key, const Participant& who, std::optional<SubscriptionSpec> spec);
  bool take_frames();
  void on_frame(const EarlyFrames::Sender& sender, ByteView content);
  void buffer(const EarlyFrames::Sender& sender, ByteView content);
  void drop_expired_frames();
  void deliver(OwnerId id, ByteView content);

  Channel* channel_to(OwnerId id, Peer& peer);
  Peer* find_up(OwnerId id);
  void retry_flush();
  void flush();
  void flush(Channel& channel);
  bool flush_slots();
  bool write_slot(std::uint32_t number, const Bytes& content);
  bool write_presence();
  void warn(const std::string& subject, const std::string& text) { limited_log_.warning(subject, text); }

  OwnerId self_;
  Scheduler& scheduler_;
  Log log_;
  base::LimitedLog limited_log_;
  Duration lease_;
  std::string host_;
  HostPolicy policy_;
  std::shared_ptr<ComponentStarts> starts_;
  std::string summary_;
  bool presence_unwritten_ = false;
  Signal signal_;
  InstanceQuota presence_quota_{2 * Participants::kMaxComponents};  // these outlive the readers
  InstanceQuota interest_quota_{Interests::kMaxOfOne};
  GuardedStore presence_store_{presence_quota_}, interest_store_{interest_quota_};
  Entity participant_, presence_topic_, interest_topic_, frame_topic_;
  Entity presence_reader_, interest_reader_, frame_subscriber_, frame_reader_, presence_writer_, interest_writer_;
  LinkListener* listener_ = nullptr;
  std::uint64_t incarnation_ = 0;
  std::map<OwnerId, Peer> peers_;
  std::uint64_t starts_seen_ = 0;
  std::map<std::uint32_t, Bytes> slots_;            ///< contents; empty = no subscription
  std::map<std::uint32_t, std::uint32_t> slot_of_;  ///< by subscription id
  std::set<std::uint32_t> free_slots_, unwritten_slots_;
  std::deque<OwnerId> gone_;  ///< of peers_, in the order in which they went down
  Writers writers_;
  Participants participants_;
  Interests interests_{participants_};
  EarlyFrames early_frames_;
  Timer early_timer_;
  IdConflicts id_conflicts_;
  OwnerId reading_from_{};
  base::OncePerTurn flush_soon_{scheduler_, [this] { flush(); }};  ///< so that the changes of a turn are sent together
  base::Deadline flush_retry_{scheduler_, [this] { flush(); }};
};

}  // namespace rubicon::tuples::dds
