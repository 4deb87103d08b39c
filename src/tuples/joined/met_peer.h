#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/scheduler.h"
#include "tuples/link.h"

namespace rubicon::tuples::joined {

/// A component as one engine sees it.
struct Meeting {
  PeerIdentity identity;
  SteadyTime since{};
  std::string summary;
  std::map<std::uint32_t, SubscriptionSpec> subscriptions;
  bool left = false;    ///< the component left on the engine where it lived; this engine has not noticed yet
  bool barred = false;  ///< it is not believed to be of this host: it lives nowhere
  Timer conflict;       ///< until the conflict with another component of this id is logged
};

/// What the engines of a joined link see of one id, and the engine where the component with that id lives: messages to
/// it go there. Several meetings with one incarnation are one component; a stand-in of it is used only where
/// the component itself is not met; any other is a rival. Engines are numbered in their order.
class MetPeer {
 public:
  explicit MetPeer(std::size_t engines) : meetings_(engines) {}

  /// What the listener has to be informed of, in this order.
  struct Move {
    std::optional<PeerIdentity> down;
    PeerEvent how = PeerEvent::kLost;
    std::optional<std::size_t> up;  ///< the engine where the component lives now
    bool was_rival = false;         ///< what it sent so far was dropped
  };
  /// An engine met the component; that engine had no meeting before.
  Move meet(std::size_t engine, const PeerIdentity& identity, bool barred = false);
  /// An engine that has a meeting lost the component or saw it leave.
  Move part(std::size_t engine, PeerEvent how);

  Meeting* at(std::size_t engine) { return meetings_[engine] ? &*meetings_[engine] : nullptr; }
  const Meeting* at(std::size_t engine) const { return meetings_[engine] ? &*meetings_[engine] : nullptr; }
  std::optional<std::size_t> home() const { return home_; }
  /// Whether the engine has a meeting with the component that lives here.
  bool is_resident(std::size_t engine) const;
  bool is_forgotten() const;
  /// Another engine that met a different component.
  std::optional<std::size_t> rival_of(std::size_t engine) const;

  /// Takes note that a stream begins. False: an earlier stream, which another one replaced. A beginning without a time
  /// is one that the engine itself notices (its connection is back): it never takes over from another engine.
  bool begin_stream(std::size_t engine, const Restart& restart);
  /// Whether changes that this engine brings count.
  bool counts(std::size_t engine) const { return !stream_ || stream_->engine == engine; }

 private:
  bool comes_before(std::size_t engine, const PeerIdentity& news) const;
  std::optional<std::size_t> next_home(std::uint64_t incarnation) const;
  Move live_at(std::optional<std::size_t> engine);

  /// The stream of changes that began last, by the clock of the component that sends it.
  struct Stream {
    std::size_t engine = 0;
    PeerIdentity sender;
    WallTime since{};
  };

  std::vector<std::optional<Meeting>> meetings_;  ///< by engine
  std::optional<std::size_t> home_;
  std::optional<Stream> stream_;
};

/// Whether `news` is a later start of the component `before`, and not another component: of two starts on one host the
/// earlier one has ended, or will be displaced.
bool is_restart(const PeerIdentity& before, const PeerIdentity& news);

}  // namespace rubicon::tuples::joined
