#include <chrono>
#include <functional>
#include <stdexcept>
#include <utility>

#include "ecology/measurements.h"
#include "transport/local_transports.h"
#include "tuples/dds/dds_ecology.h"
#include "tuples/host/folder.h"
#include "tuples/host/host_ecology.h"

namespace rubicon::bench {

namespace {

/// The folder of RUBICON_FOLDER, in a space of the meeting.
class OnHost final : public tuples::Ecology {
 public:
  OnHost(const Meeting& meeting, transport::Loop& loop, base::LogSink& log) : transports_(loop) {
    const auto place = tuples::host::choose_place({}, tuples::host::Surroundings::of_process());
    auto folder = tuples::host::open_disk_folder(place.value(), meeting.tag, loop.scheduler(), transports_);
    if (!folder) throw std::runtime_error(folder.error().text);
    auto ecology = tuples::host::HostEcology::open(std::move(*folder), {}, loop.scheduler(), log);
    if (!ecology) throw std::runtime_error(ecology.error().text);
    ecology_ = std::move(*ecology);
  }
  Result<std::unique_ptr<tuples::Link>> join(OwnerId id) override { return ecology_->join(id); }

 private:
  transport::LocalTransports transports_;
  std::unique_ptr<tuples::host::HostEcology> ecology_;
};

std::shared_ptr<tuples::Ecology> open_dds(const Meeting& meeting, transport::Loop& loop, base::LogSink& log) {
  const auto post = [&loop](std::function<void()> call) { loop.scheduler().post(std::move(call)); };
  auto ecology = tuples::dds::DdsEcology::open(options_of(meeting), loop.scheduler(), post, log);
  if (!ecology) throw std::runtime_error(ecology.error().text);
  return std::move(*ecology);
}

}  // namespace

std::shared_ptr<tuples::Ecology> open_one(const Meeting& meeting, transport::Loop& loop, base::LogSink& log) {
  if (meeting.engine == "host") return std::make_shared<OnHost>(meeting, loop, log);
  return open_dds(meeting, loop, log);
}

tuples::dds::DdsOptions options_of(const Meeting& meeting) {
  tuples::dds::DdsOptions options;
  options.domain = meeting.domain;
  options.tag = meeting.tag;
  options.lease = std::chrono::duration_cast<base::Duration>(std::chrono::duration<double>(lease_seconds()));
  return options;
}

}  // namespace rubicon::bench
