#pragma once

#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "base/scheduler.h"
#include "tuples/link.h"
#include "tuples/mqtt/messages.h"
#include "tuples/mqtt/topics.h"

namespace rubicon::tuples::mqtt {

/// A component as it is reached at the moment.
struct Reached {
  Line line;
  ComponentShown shown;
};

/// Who is there, by the retained topics of the space: a component is there as long as its topic and the topic of its
/// connection exist. Without I/O.
///
/// A connection whose topic goes may come back as another one of the same start: its components are lost only after
/// kReturn. While this process has no connection itself, and after it read presence again, others have their lease.
class Presence {
 public:
  struct Callbacks {
    /// Another component is reached by that id, or none; `how`: how the last one ended, if there is none any longer.
    std::function<void(OwnerId id, PeerEvent how)> changed;
    /// Nothing of that connection, or of its topic, is left.
    std::function<void(const Line& line)> forgotten;
    /// Whether that user may have the id; what it shows counts only while it may. Empty: each may.
    std::function<bool(const Line& line, OwnerId id)> allowed = {};
  };
  static constexpr Duration kReturn = std::chrono::seconds(3);
  /// Bytes of all kept presence, and of the presence of one user.
  static constexpr std::size_t kMaxBytes = std::size_t{64} << 20, kMaxUserBytes = std::size_t{8} << 20;

  Presence(Scheduler& scheduler, Callbacks calls);

  /// False: no room for one more.
  bool show(const Line& line, const LineShown& shown);
  /// All components of this process: they meet without a broker, too. `line` stands for this process and is known to no
  /// other one; the one of the first call stays until the user changes.
  void show_here(const Line& line, Duration lease, const std::map<OwnerId, ComponentShown>& components);
  bool is_here(const Line& line) const { return line == here_; }
  void hide(const Line& line);
  bool show(const Line& line, OwnerId id, ComponentShown shown);
  /// The topic of the component became empty: as hide(), for this component alone.
  void fade(const Line& line, OwnerId id);
  /// The component announced that it leaves.
  void leave(const Line& line, OwnerId id) { remove(line, id, PeerEvent::kLeft); }

  /// The own connection is lost: others may stay unseen for their lease.
  void cut();
  /// The topic of the connection itself is being read, however long that takes: end_reading() follows.
  void await(const Line& line);
  /// All that is retained of the connection was read: without its own topic it is gone.
  void end_reading(const Line& line);
  /// Everything will be read again.
  void begin_reading();
  /// All that is looked for was read again: connections that were not seen have their lease; what was not seen of the
  /// others is gone. `all`: no connection is awaited any longer.
  void end_reading(bool all);
  /// `doubted`: no component there answers; its topics do not count until one does (false).
  void doubt(const Line& line, OwnerId id, bool doubted);
  /// Those that are reached while their user shows another start of them, too, and that did not answer since. Which one
  /// lives, topics cannot tell: a broker may have those of before its restart, and the clock of a host may go back.
  std::vector<OwnerId> contested() const;
  /// Callbacks::allowed may have another answer now.
  void review_all();
  using Shown = std::shared_ptr<const Reached>;
  std::vector<std::pair<OwnerId, Shown>> doubted() const;

  /// What was shown on that line.
  std::vector<OwnerId> shown_on(const Line& line) const;
  /// nullptr: not there. One object for all callers, as long as the component is reached in this way.
  Shown reached(OwnerId id) const;
  bool has(const Line& line) const { return lines_.contains(line); }
  std::vector<OwnerId> all() const;
  std::size_t bytes() const { return bytes_; }
  /// Presences of others with that id, whether they count or not.
  std::vector<Shown> all_with(OwnerId id) const;

 private:
  /// A component on a connection.
  struct Component {
    Shown as;
    bool seen = true, doubted = false;
    bool answered = false;                 ///< since it was shown
    SteadyTime until = SteadyTime::max();  ///< while its topic is there: max
  };
  struct LineState {
    LineShown shown;
    SteadyTime until = SteadyTime::max();  ///< while its topic is there: max
    bool here = false, seen = false;
    std::set<OwnerId> ids;
  };
  Component* find(const Line& line, OwnerId id);
  bool add_bytes(const std::string& user, std::size_t more, std::size_t less);
  bool counts(OwnerId id, const Component& one) const;
  bool is_rival(OwnerId id, const Component& one, const Reached& reached) const;
  Shown best(OwnerId id) const;
  bool is_better(const Reached& one, const Reached& other) const;
  void forget_former(OwnerId id, const Reached& now);
  void review(OwnerId id, PeerEvent how);
  void remove(const Line& line, OwnerId id, PeerEvent how);
  void expire();
  void end_at(SteadyTime& until, SteadyTime when);

  Scheduler& scheduler_;
  Callbacks callbacks_;
  Line here_;
  std::map<Line, LineState> lines_;
  std::map<OwnerId, std::map<Line, Component>> components_;
  std::map<OwnerId, Shown> reached_;
  std::size_t bytes_ = 0;
  std::map<std::string, std::size_t> bytes_of_;  ///< by user
  base::Deadline expiry_;
};

}  // namespace rubicon::tuples::mqtt
