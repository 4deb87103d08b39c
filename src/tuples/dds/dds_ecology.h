#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/clocks.h"
#include "base/log.h"
#include "base/scheduler.h"
#include "rubicon/time.hpp"
#include "rubicon/tuple.hpp"
#include "transport/interfaces.h"
#include "tuples/dds/dds_options.h"
#include "tuples/link.h"

namespace rubicon::tuples::dds {

/// Version of frames, interests and presence (docs/ecology.md). Components with another one are seen but ignored.
inline constexpr std::uint16_t kProtocolVersion = 3;

/// One start (incarnation) of a component, from its presence.
struct ComponentStart {
  OwnerId id{};
  std::uint64_t incarnation = 0;
  std::uint16_t version = 0;  ///< 0 = not known
  bool present = false;
  std::string summary;
  std::uint64_t publication = 0;  ///< DDS handle of what showed it first
};

/// The starts that were observed, for diagnostics: those that are present, and the last that ended.
class ComponentStarts {
 public:
  static constexpr std::size_t kMax = 1000, kMaxGone = 100;

  void note(ComponentStart news) {
    const Name name(news.id, news.incarnation);
    if (!news.present) return end(name);
    const auto known = all_.find(name);
    if (known != all_.end() && known->second.present) news.publication = known->second.publication;
    if (known != all_.end() || all_.size() < kMax) all_[name] = std::move(news);
  }
  /// Ends all that are present and for which `stays` is false.
  template <class Stays>
  void keep_only(Stays stays) {
    std::vector<Name> over;
    for (const auto& [name, one] : all_) {
      if (one.present && !stays(one)) over.push_back(name);
    }
    for (const auto& name : over) end(name);
  }
  std::vector<ComponentStart> all() const {
    std::vector<ComponentStart> list;
    for (const auto& entry : all_) list.push_back(entry.second);
    return list;
  }

 private:
  using Name = std::pair<OwnerId, std::uint64_t>;

  void end(const Name& name) {
    const auto known = all_.find(name);
    if (known == all_.end() || !std::exchange(known->second.present, false)) return;
    gone_.push_back(name);
    if (gone_.size() > kMaxGone) forget(gone_.front());
  }
  void forget(const Name& name) {
    const auto known = all_.find(name);
    if (known != all_.end() && !known->second.present) all_.erase(known);
    gone_.pop_front();
  }

  std::map<Name, ComponentStart> all_;
  std::deque<Name> gone_;  ///< in the order in which they ended
};

/// What became of the interfaces that DDS uses, since the start.
struct InterfaceNews {
  struct State {
    std::string address;  ///< IPv4; empty = none
    std::string lack;     ///< why it reaches no other host: `has no IPv4 address`; empty = nothing
    friend bool operator==(const State&, const State&) = default;
  };
  std::map<std::string, State> interfaces;  ///< by name; empty until they were looked at
  std::uint64_t changes = 0;                ///< how often the components entered with other addresses
  WallTime changed{};                       ///< the last time
};

/// The components of all processes and hosts that share a DDS domain. At most one object per process and domain; it
/// outlives its links. The threads of DDS only raise a flag and post a call.
class DdsEcology final : public StandInEcology {
 public:
  /// Runs the call on the loop's thread, in a later turn. Called from any thread; must outlive the ecology.
  using Post = std::function<void(std::function<void()>)>;

  /// kBusy: this process has one in that domain; kIo: the network cannot be used as configured;
  /// the text has the reason from DDS. `since_boot`: the age of frames counts by it.
  static Result<std::unique_ptr<DdsEcology>> open(DdsOptions options, Scheduler& scheduler, Post post,
                                                  base::LogSink& log,
                                                  std::function<Duration()> since_boot = base::since_boot);
  ~DdsEcology() override;

  /// The component is seen by others from the link's attach() on. kIo as for open().
  Result<std::unique_ptr<Link>> join(OwnerId id) override;
  Result<std::unique_ptr<Link>> join_as(StandIn who) override;

  /// `call` receives, in a later turn and once per start, the component of this process whose id another process uses
  /// and used before. That component should end, so that all others see the same one.
  void watch_displaced(std::function<void(OwnerId)> call);

  /// All links leave the domain, it is made again with the interfaces as they are now, and the links enter it with new
  /// participants, in later turns. Own tuples and subscriptions stay; others are lost until they are met again. If the
  /// domain cannot be opened, the links are outside, and it is tried again every second.
  void enter_again();

  /// From now on the interfaces of the options are followed: when their addresses changed, all links leave the domain,
  /// it is made again on those that can be used, and the links enter it. Tuples and subscriptions stay; the others are
  /// lost and met again. Nothing happens with loopback alone.
  void follow(const transport::WatchInterfaces& watch);
  /// Empty before follow().
  const InterfaceNews& interfaces() const;

  /// Whether components were found whose presence has not arrived yet.
  bool expects_components() const;

  /// The component starts that the links of this process observed, including ignored ones.
  std::vector<ComponentStart> component_starts() const;
  /// How many participants of the domain show no component to the links of this process: other programs than ours, or
  /// releases that had certificates for DDS.
  std::size_t silent_participants() const;

 private:
  struct Impl;
  explicit DdsEcology(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace rubicon::tuples::dds
