#pragma once

#include <map>
#include <optional>
#include <set>

#include "base/log.h"
#include "base/rate_limit.h"
#include "tuples/dds/dds_ecology.h"
#include "tuples/dds/guarded_store.h"
#include "tuples/dds/held_frames.h"
#include "tuples/dds/host_policy.h"
#include "tuples/dds/interests.h"
#include "tuples/dds/peer.h"
#include "tuples/dds/signal.h"
#include "tuples/dds/twins.h"

namespace rubicon::tuples::dds {

/// One component's end of the ecology (docs/ecology.md): says that it is there and what it subscribes to, and has a
/// channel to each component it tells something.
class DdsLink final : public Link, private FrameReader {
 public:
  /// Makes all that it needs of DDS; kIo names what cannot be made. `displaced` is called in a later turn when another
  /// process has the id, and had it before.
  static Result<std::unique_ptr<DdsLink>> make(OwnerId self, Entity participant, const DdsOptions& options,
                                               Scheduler& scheduler, DdsEcology::Post post,
                                               std::function<void()> displaced, std::shared_ptr<ComponentStarts> starts,
                                               base::LogSink& log);
  ~DdsLink() override;

  void attach(LinkListener* listener) override;
  bool publish(OwnerId subscriber, std::span<const Change> changes) override;
  void subscribe(const SubscriptionSpec& spec) override;
  void unsubscribe(std::uint32_t id) override;
  Result<void> remote_set(const RemoteSet& set) override;
  void reply(const Reply& reply) override;
  std::vector<OwnerId> peers() const override;
  void describe(std::string summary) override;
  PeerPolicy& policy() override { return policy_; }

 private:
  DdsLink(OwnerId self, Entity participant, const DdsOptions& options, Scheduler& scheduler, DdsEcology::Post post,
          std::function<void()> displaced, std::shared_ptr<ComponentStarts> starts, base::LogSink& log);

  // FrameReader: the entries of the frame at hand
  void on_changes(std::span<const Change> changes) override;
  void on_set(RemoteSet&& set) override;
  void on_reply(Reply&& reply) override;
  void on_identity_check(const IdentityCheck&) override {}  // between twins only

  Result<void> make_entities();
  Result<void> make_topics();
  Result<void> make_readers();
  Result<void> make_writers();
  void leave();
  void forget_all();
  void drain(unsigned sources);

  // -- presence (dds_link_presence.cpp)
  /// What is heard of a component's presence.
  struct PresenceNews {
    Participants::Start who;
    dds_instance_handle_t publication = 0;
    bool there = false, left = false;
    std::uint16_t version = 0;  ///< this and the rest only of those that are there
    Peer::Start start;
  };
  void take_presences();
  bool is_taken(const PresenceNews& news);
  void present(const PresenceNews& news);
  void appear(Peer& peer, const PresenceNews& news);
  Peer::Starts::iterator superfluous(Peer& peer, std::uint64_t newcomer);
  void forget(OwnerId id, Peer& peer, Peer::Starts::iterator start);
  void absent(const Participants::Start& who, bool left);
  void ban(const Participant& who);
  Peer* know(OwnerId id);
  void make_room();
  void forget_gone_peers();
  void settle(OwnerId id, Peer& peer, bool left);
  void tell_summary(OwnerId id, Peer& peer);
  void come(OwnerId id, Peer& peer, std::uint64_t incarnation);
  void go(OwnerId id, Peer& peer, PeerEvent event);
  void forget_gone_writers();

  // -- what they say (dds_link_reading.cpp)
  void take_interests();
  void interest(const InterestKey& key, const Participant& who, std::optional<SubscriptionSpec> spec);
  bool take_frames();
  void frame(const HeldFrames::Sender& sender, ByteView content);
  void hold(const HeldFrames::Sender& sender, ByteView content);
  void drop_held();
  void tell(OwnerId id, ByteView content);

  Channel* channel_to(OwnerId id, Peer& peer);
  Peer* find_up(OwnerId id);
  void ask_flush(Duration within);
  void ask_flush();
  void flush();
  void flush(Channel& channel);
  bool flush_slots();
  bool write_slot(std::uint32_t number, const Bytes& content);
  bool write_presence();
  void warn(const std::string& subject, const std::string& text);

  OwnerId self_;
  Scheduler& scheduler_;
  Log log_;
  base::RateLimit log_limit_;
  Duration lease_;
  std::string host_;
  HostPolicy policy_;
  std::shared_ptr<ComponentStarts> starts_;
  std::string summary_;
  bool presence_unwritten_ = false;
  Signal signal_;
  InstanceQuota presence_quota_{2 * Participants::kMostComponents};  // these outlive the readers
  InstanceQuota interest_quota_{Interests::kMostOfOne};
  GuardedStore presence_store_{presence_quota_}, interest_store_{interest_quota_};
  Entity participant_, presence_topic_, interest_topic_, frame_topic_;
  Entity presence_reader_, interest_reader_, frame_subscriber_, frame_reader_, presence_writer_, interest_writer_;
  LinkListener* listener_ = nullptr;
  std::uint64_t incarnation_ = 0;
  std::map<OwnerId, Peer> peers_;
  std::uint64_t starts_seen_ = 0;
  std::map<std::uint32_t, Bytes> slots_;            ///< what stands in them; empty = nothing
  std::map<std::uint32_t, std::uint32_t> slot_of_;  ///< by subscription id
  std::set<std::uint32_t> free_slots_, unwritten_slots_;
  std::deque<OwnerId> gone_;  ///< of peers_, those that went first in front
  Writers writers_;
  Participants participants_;
  Interests interests_{participants_};
  HeldFrames held_;
  Timer held_timer_;
  Twins twins_;
  OwnerId reading_from_{};
  Timer flush_timer_;
  SteadyTime flush_at_ = SteadyTime::max();
  bool flush_posted_ = false;
  std::shared_ptr<bool> door_ = std::make_shared<bool>();  ///< posted calls come through it while the link is there
};

}  // namespace rubicon::tuples::dds
