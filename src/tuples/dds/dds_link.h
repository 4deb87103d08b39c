#pragma once

#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "base/log.h"
#include "base/scheduler.h"
#include "tuples/dds/channel.h"
#include "tuples/dds/frames.h"
#include "tuples/dds/id_conflicts.h"
#include "tuples/dds/interests.h"
#include "tuples/dds/link_entities.h"
#include "tuples/dds/presences.h"
#include "tuples/peer_policy.h"

namespace rubicon::tuples::dds {

/// The link of one component over DDS (docs/ecology.md): publishes its presence and its subscriptions, and has a
/// channel to each component to which it sends. What arrives goes through its parts: Presences, Subscribers, Frames.
class DdsLink final : public Link, private PresenceNotifier {
 public:
  /// Makes its DDS entities; kIo names the one that cannot be made. `displaced` is called if another process uses the
  /// id, and used it before.
  /// An empty host is that of this machine.
  static Result<std::unique_ptr<DdsLink>> make(StandIn who, Entity participant, LinkShared& shared);
  ~DdsLink() override;

  /// Whether a writer of a presence is matched that has brought none yet.
  bool expects_presence() const { return presences_.expects(); }
  /// The processes in which this link sees a component, and its own one.
  std::set<Participant> participants_with_components() const;
  dds_entity_t participant() const { return entities_.participant(); }
  OwnerId id() const { return own_.id; }

  // -- other addresses
  /// Leaves the domain, and takes out what is to be deleted with it. The listener sees that all others are lost; what
  /// it asks for meanwhile is kept.
  void leave_behind(FormerDomain::Remains& remains);
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
  std::vector<OwnerId> peers() const override { return presences_.up(); }
  void describe(std::string summary) override;
  PeerPolicy& policy() override { return *policy_; }

 private:
  DdsLink(StandIn who, Entity participant, LinkShared& shared);

  // PresenceNotifier
  void on_met(const Sender& sender, bool again) override;
  void on_lost(OwnerId id) override;
  void on_forgotten(OwnerId id) override { frames_.forget(id); }
  void on_shut_out(const Participant& who) override { subscribers_.shut_out(who); }

  void drain(unsigned sources);
  bool take_presences();
  void enter();
  void correct_start();
  void leave();
  void delete_apart(const std::function<void()>& removal);
  void collect_frames();
  void say_goodbye();
  void await_receivers();
  void drop_held();

  Channel* channel_to(OwnerId id);
  void send_times(OwnerId id, bool asks);
  Channel::State write_frames(OwnerId id, Channel& channel);
  bool write_presence();
  void repeat_interests();
  void retry_flush();
  void flush();

  OwnStart own_;
  LinkShared& shared_;
  base::LimitedLog log_;
  std::string host_;
  std::unique_ptr<PeerPolicy> policy_;
  std::string summary_;
  bool presence_unwritten_ = false;
  Signal signal_;
  LinkEntities entities_;
  IdConflicts id_conflicts_;
  Presences presences_;
  Subscribers subscribers_;
  Frames frames_;
  OwnInterests interests_;
  std::map<OwnerId, std::unique_ptr<Channel>> channels_;  ///< to those that are up, when there is something to send
  base::OncePerTurn flush_soon_;                          ///< so that the changes of a turn are sent together
  /// Paced, because a component that comes and goes would make all owners send everything again.
  base::PacedCall repeat_soon_;
  base::Deadline flush_retry_;
};

}  // namespace rubicon::tuples::dds
