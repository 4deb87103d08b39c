#pragma once

#include <functional>
#include <memory>

#include "base/log.h"
#include "base/scheduler.h"
#include "tuples/dds/component_starts.h"
#include "tuples/dds/dds_options.h"
#include "tuples/link.h"

namespace rubicon::tuples::dds {

/// The components of all processes and hosts that share a DDS domain. At most one a process and domain; outlives the
/// links it makes, whose scheduler it uses. DDS has threads of its own: they raise a flag and post one call, nothing
/// else.
class DdsEcology final : public Ecology {
 public:
  /// Makes a call on the loop's thread, in a later turn. Called from any thread; must outlive the ecology.
  using Post = std::function<void(std::function<void()>)>;

  /// kBusy: this process has one in that domain; kIo: the network does not work as configured, with DDS's word for it.
  static Result<std::unique_ptr<DdsEcology>> open(DdsOptions options, Scheduler& scheduler, Post post,
                                                  base::LogSink& log);
  ~DdsEcology() override;

  /// The component is seen by others from the link's attach() on. kIo as for open().
  Result<std::unique_ptr<Link>> join(OwnerId id) override;

  /// `call` is told, in a later turn and once a start, which component of this process has an id that another process
  /// has too, and had before: it should go, so that all who look see the same one.
  void watch_displaced(std::function<void(OwnerId)> call);

  /// What the links of this process met, also what they do not talk to.
  std::vector<ComponentStart> component_starts() const;

 private:
  struct Impl;
  explicit DdsEcology(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace rubicon::tuples::dds
