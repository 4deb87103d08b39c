#pragma once

#include <functional>
#include <memory>

#include "base/boot_time.h"
#include "base/log.h"
#include "base/scheduler.h"
#include "transport/interface_watch.h"
#include "tuples/dds/component_starts.h"
#include "tuples/dds/dds_options.h"
#include "tuples/dds/interface_news.h"
#include "tuples/stand_in.h"

namespace rubicon::tuples::dds {

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
  /// participants, in a later turn. Own tuples and subscriptions stay; others are lost until they are met again. If the
  /// domain cannot be opened, the links are outside, and it is tried again every few seconds.
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
