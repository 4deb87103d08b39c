#include "tuples/dds/dds_ecology.h"

#include <fmt/format.h>

#include "tuples/dds/dds_link.h"
#include "tuples/dds/entity.h"

namespace rubicon::tuples::dds {

struct DdsEcology::Parts {
  DdsOptions options;
  Scheduler& scheduler;
  Post post;
  base::LogSink& log;
  Entity domain;
  std::shared_ptr<Appearances> appearances = std::make_shared<Appearances>();
  std::shared_ptr<std::function<void(OwnerId)>> displaced = std::make_shared<std::function<void(OwnerId)>>();
};

DdsEcology::DdsEcology(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
DdsEcology::~DdsEcology() = default;

Result<std::unique_ptr<DdsEcology>> DdsEcology::open(DdsOptions options, Scheduler& scheduler, Post post,
                                                     base::LogSink& log) {
  const auto xml = domain_xml(options);
  const auto answer = dds_create_domain(options.domain, xml.c_str());
  if (answer == DDS_RETCODE_PRECONDITION_NOT_MET)
    return fail(ErrorCode::kBusy, fmt::format("DDS domain {} is open in this process already", options.domain));
  auto domain = made(answer, fmt::format("domain {}", options.domain));
  if (!domain) return fail(std::move(domain.error()));
  return std::unique_ptr<DdsEcology>(new DdsEcology(
      std::make_unique<Parts>(Parts{std::move(options), scheduler, std::move(post), log, std::move(*domain)})));
}

Result<std::unique_ptr<Link>> DdsEcology::join(OwnerId id) {
  auto participant = made(dds_create_participant(parts_->options.domain, nullptr, nullptr),
                          fmt::format("participant of component {}", number(id)));
  if (!participant) return fail(std::move(participant.error()));
  const auto displaced = [call = std::weak_ptr(parts_->displaced), id] {
    if (const auto told = call.lock(); told && *told) (*told)(id);
  };
  return std::make_unique<DdsLink>(id, std::move(*participant), parts_->options.lease, parts_->scheduler, parts_->post,
                                   displaced, parts_->appearances, parts_->log);
}

std::vector<Appearance> DdsEcology::appearances() const {
  return parts_->appearances->all();
}

void DdsEcology::watch_displaced(std::function<void(OwnerId)> call) {
  *parts_->displaced = std::move(call);
}

}  // namespace rubicon::tuples::dds
