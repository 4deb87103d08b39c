#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "base/log.h"
#include "tuples/dds/entity.h"
#include "tuples/dds/id_conflicts.h"
#include "tuples/dds/link_entities.h"
#include "tuples/dds/reader_stores.h"
#include "tuples/peer_policy.h"

namespace rubicon::tuples::dds {

/// Another component. Each start has an incarnation; later starts have higher ones.
struct Peer {
  static constexpr std::size_t kMaxStarts = 4;

  /// The presence of one start, and the DDS participant that wrote it.
  struct Start {
    Participant participant{};
    std::string host, summary;
    dds_instance_handle_t publication = 0;
    std::uint64_t place = 0;  ///< order of arrival
    /// Another participant that shows the same start. It takes over when this one goes, as when the component entered
    /// the domain again and the end of its former participant was not noticed here yet.
    std::shared_ptr<const Start> heir;
  };
  using Starts = std::map<std::uint64_t, Start>;
  /// The starts that are present, by incarnation: at most one per participant, kMaxStarts in all. The highest counts.
  /// There are two if the component has just restarted or two processes use its id.
  Starts alive;

  std::uint64_t incarnation = 0;  ///< reported to the listener; 0 = down
  std::uint64_t latest = 0;       ///< the highest that was reported since this program knows the component
  Participant participant{};      ///< of that incarnation
  std::string host, summary;      ///< reported to the listener

  bool is_up() const { return incarnation != 0; }
};

/// What follows when a component comes or goes.
class PresenceNotifier {
 public:
  virtual ~PresenceNotifier() = default;
  /// It is up; `again`: that start, or a later one, was up before. May detach the link.
  virtual void on_met(const Sender& sender, bool again) = 0;
  /// It is down; the listener of the link hears it next.
  virtual void on_lost(OwnerId id) = 0;
  /// What it sent before counts no longer.
  virtual void on_forgotten(OwnerId id) = 0;
  /// The participant is ignored from now on.
  virtual void on_shut_out(const Participant& who) = 0;
};

/// Who is there, and which start of it, as the presences on the wire show. Tells the listener of the link and asks its
/// policy; nothing else of the link does. Bounded: components in all, and for each DDS participant.
class Presences {
 public:
  /// All must outlive it.
  Presences(const OwnStart& own, LinkShared& shared, LinkEntities& entities, PeerPolicy& policy, IdConflicts& conflicts,
            base::LimitedLog& log, PresenceNotifier& notifier)
      : own_(own),
        shared_(shared),
        entities_(entities),
        policy_(policy),
        conflicts_(conflicts),
        log_(log),
        notifier_(notifier) {}

  /// A sample of a component's presence.
  struct News {
    Participants::Start who;
    bool there = false, left = false;
    std::uint16_t version = 0;  ///< this and the rest: only if it is present
    Peer::Start start;          ///< of an absence the publication only
  };
  struct Arrived {
    std::vector<News> news;
    bool some_ended = false;
    bool more = false;  ///< may be waiting
  };
  /// Takes at most about kSamples from the wire.
  Arrived take();
  /// Acts on what was taken. True: publications of presence are gone.
  bool apply(const std::vector<News>& news);

  /// nullptr: it is down. Valid until the next call of something that is not const.
  const Peer* find_up(OwnerId id) const;
  std::vector<OwnerId> up() const;
  /// The participants that show these.
  std::set<Participant> participants_up() const;
  /// Whether a writer of a presence is matched that has brought none yet.
  bool expects() const;

  /// Who wrote a sample, by DDS; nullptr: its writer went before a sample of it was read.
  const Writer* writer(dds_entity_t reader, dds_instance_handle_t publication) {
    return writers_.find(reader, publication);
  }
  bool is_banned(const Participant& who) const { return participants_.is_banned(who); }
  Participants& participants() { return participants_; }
  /// So that nothing is kept of participants that come and go.
  void forget_gone_writers();

  /// The domain is left: all that are up are lost. They count as known.
  void lose_all();
  /// The component leaves: nobody is told.
  void clear();

 private:
  void note_end(InstanceQuota::Handle publication, InstanceQuota::Handle instance);
  bool may_end(const News& news) const;
  bool admit(const News& news);
  PeerIdentity identity_of(OwnerId id, std::uint64_t incarnation, const Peer::Start& start) const;
  void on_presence(const News& news);
  void add_start(Peer& peer, const News& news);
  static Peer::Starts::iterator excess_start(Peer& peer, std::uint64_t newcomer);
  void remove_start(OwnerId id, Peer& peer, Peer::Starts::iterator start);
  void on_absence(const News& news);
  void end_start(const Participants::Start& who, bool left);
  bool is_alive(OwnerId id, std::uint64_t incarnation) const;
  bool end_unmatched();
  void ban(const Participant& who);
  void shut_out(const Participant& who);
  Peer* find_or_add(OwnerId id);
  void evict();
  void forget_gone();
  void drop_gone();
  void select_incarnation(OwnerId id, Peer& peer, bool left);
  void report_summary(OwnerId id, Peer& peer);
  void peer_up(OwnerId id, Peer& peer, std::uint64_t incarnation);
  void peer_down(OwnerId id, Peer& peer, PeerEvent event);
  void forget_domain();

  const OwnStart& own_;
  LinkShared& shared_;
  LinkEntities& entities_;
  PeerPolicy& policy_;
  IdConflicts& conflicts_;
  base::LimitedLog& log_;
  PresenceNotifier& notifier_;
  std::map<OwnerId, Peer> peers_;
  std::deque<OwnerId> gone_;  ///< of peers_, in the order in which they went down
  std::uint64_t starts_seen_ = 0;
  std::uint32_t unmatched_seen_ = 0;  ///< of the publications of presence
  Writers writers_;
  Participants participants_;
  EndedInstances ended_;
};

}  // namespace rubicon::tuples::dds
