#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "base/log.h"
#include "base/scheduler.h"
#include "tuples/dds/early.h"
#include "tuples/dds/id_conflicts.h"
#include "tuples/dds/link_entities.h"
#include "tuples/dds/presences.h"
#include "tuples/distant/frame_codec.h"

namespace rubicon::tuples::dds {

/// What arrives from whom: takes the frames from the wire, asks who is there, and passes their entries to the listener
/// of the link (docs/life-of-a-frame.md). Holds, within bounds, frames that come before the presence of their sender,
/// and remote sets until their age is known.
class Frames final : private distant::FrameReader {
 public:
  /// What this link sends because of what arrives.
  struct Answers {
    std::function<void(const Reply&)> reply;
    /// Puts the times (FrameTimes) into the next frame to this component. `asks`: they ask it for its own.
    std::function<void(OwnerId to, bool asks)> times;
  };

  /// All must outlive it.
  Frames(const OwnStart& own, const LinkShared& shared, const LinkEntities& entities, Presences& presences,
         IdConflicts& conflicts, base::LimitedLog& log, Answers answers)
      : own_(own),
        shared_(shared),
        entities_(entities),
        presences_(presences),
        conflicts_(conflicts),
        log_(log),
        answers_(std::move(answers)) {}

  /// Takes frames from the wire and passes them on. True: more may have arrived.
  bool take();
  /// Takes those that arrived from the wire, for the next take(). Returns their number.
  std::size_t collect();
  /// The component is up: passes on what came before its presence.
  void met(const Sender& sender);
  /// It is down.
  void lost(OwnerId id) { senders_[id].ages = {}; }
  void forget(OwnerId id) { senders_.erase(id); }
  /// Drops what is held.
  void drop_held();
  void clear();

  /// With what a frame to the component begins; `asks` as for Answers::times.
  distant::FrameTimes times_for(OwnerId id, bool asks) const;

 private:
  struct News {
    Sender sender;
    Bytes content;
  };
  struct From {
    distant::FrameAges ages;
    std::uint64_t last_request = 0;  ///< highest number of its remote sets; repetitions are dropped
    std::uint64_t requests_of = 0;   ///< the incarnation that sent them
  };

  void place(const Sender& sender, ByteView content);
  void hold(const Sender& sender, ByteView content);
  void drop_expired();
  void deliver(OwnerId id, ByteView content);

  // FrameReader: the entries of the present frame
  void on_changes(std::span<const Change> changes) override;
  void on_set(RemoteSet&& set) override;
  void on_reply(Reply&& reply) override;
  void on_times(const distant::FrameTimes& times) override;

  // remote sets
  void take_set(EarlySets::One&& one);
  bool is_early(const EarlySets::One& one) const;
  bool waits_for_times(const EarlySets::One& one) const;
  void hold_early(EarlySets::One&& one);
  void take_early_after(Duration pause);
  void take_early();
  Duration left_of(const EarlySets::One& one) const;
  std::optional<Duration> age_of(const EarlySets::One& one) const;

  const OwnStart& own_;
  const LinkShared& shared_;
  const LinkEntities& entities_;
  Presences& presences_;
  IdConflicts& conflicts_;
  base::LimitedLog& log_;
  Answers answers_;
  std::vector<News> news_;
  std::map<OwnerId, From> senders_;
  EarlyFrames early_frames_;
  EarlySets early_sets_;
  Timer early_timer_, early_sets_timer_;
  OwnerId reading_from_{};
  std::optional<Duration> reading_sent_;  ///< when the present frame was sent, by the clock of its sender
};

}  // namespace rubicon::tuples::dds
