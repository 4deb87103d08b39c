#pragma once

#include <functional>
#include <memory>

#include "base/boot_time.h"
#include "base/log.h"
#include "base/scheduler.h"
#include "tuples/dds/component_starts.h"
#include "tuples/dds/dds_options.h"
#include "tuples/stand_in.h"

namespace rubicon::tuples::dds {

/// The components of all processes and hosts that share a DDS domain. At most one object per process and domain; it
/// outlives its links. The threads of DDS only raise a flag and post a call.
class DdsEcology final : public StandInEcology {
 public:
  /// Runs the call on the loop's thread, in a later turn. Called from any thread; must outlive the ecology.
  using Post = std::function<void(std::function<void()>)>;

  /// kBusy: this process has one in that domain; kIo: the network cannot be used as configured;
  /// the text has the reason from DDS. With trust also the errors of DdsTrust::documents(), and kIo with the reason if
  /// the domain does not accept them. `since_boot`: the age of frames counts by it.
  static Result<std::unique_ptr<DdsEcology>> open(DdsOptions options, Scheduler& scheduler, Post post,
                                                  base::LogSink& log,
                                                  std::function<Duration()> since_boot = base::since_boot);
  ~DdsEcology() override;

  /// The component is seen by others from the link's attach() on. kIo as for open(). kRefused: the certificate of this
  /// process does not have the id.
  Result<std::unique_ptr<Link>> join(OwnerId id) override;
  Result<std::unique_ptr<Link>> join_as(StandIn who) override;

  /// `call` receives, in a later turn and once per start, the component of this process whose id another process uses
  /// and used before. That component should end, so that all others see the same one.
  void watch_displaced(std::function<void(OwnerId)> call);

  /// Reads the documents of trust again. If they are not those of the domain, all links leave it, it is made again with
  /// them, and the links enter it: true. Tuples and subscriptions stay, and requests wait; others are lost for half a
  /// second. False: nothing changed, or there is no trust. With the errors of documents() everything stays as it is.
  /// After those of open() the links are outside, and it is tried again every few seconds, as after the end of the
  /// certificate. Not to be called from a call of a link or a space.
  Result<bool> renew();

  /// Whether components were found whose presence has not arrived yet.
  bool expects_components() const;

  /// The component starts that the links of this process observed, including ignored ones.
  std::vector<ComponentStart> component_starts() const;
  /// How many participants of the domain show no component to the links of this process: with trust if this process has
  /// none, and the other way round, or other programs than ours.
  std::size_t silent_participants() const;

 private:
  struct Impl;
  explicit DdsEcology(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace rubicon::tuples::dds
