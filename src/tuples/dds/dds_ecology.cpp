#include "tuples/dds/dds_ecology.h"

#include <fmt/format.h>

#include "tuples/dds/cyclone_log.h"
#include "tuples/dds/dds_link.h"
#include "tuples/dds/entity.h"
#include "tuples/dds/host.h"

namespace rubicon::tuples::dds {

struct DdsEcology::Impl {
  DdsOptions options;
  Scheduler& scheduler;
  Post post;
  base::LogSink& log;
  std::unique_ptr<CycloneLog> words;  // outlives the domain, which still has some
  Entity domain;
  std::shared_ptr<ComponentStarts> starts = std::make_shared<ComponentStarts>();
  std::shared_ptr<std::function<void(OwnerId)>> displaced = std::make_shared<std::function<void(OwnerId)>>();
};

namespace {

/// How long a start may ask for names of hosts.
constexpr Duration kResolving = std::chrono::seconds(5);

/// kBusy or kIo, in words that say what to do where that is known.
Error cannot_open(const DdsOptions& options, dds_return_t answer, const std::string& heard) {
  if (answer == DDS_RETCODE_PRECONDITION_NOT_MET)
    return {ErrorCode::kBusy, fmt::format("DDS domain {} is open in this process already", options.domain)};
  if (heard.find("free participant index") != heard.npos) {
    return {ErrorCode::kIo,
            fmt::format(
                "DDS: domain {} has no room for one more process on this host: {} are there already (UDP ports {} to "
                "{} are taken). End some of them, or use another tuples.domain",
                options.domain, kMostOnAHost, port_of(options.domain, 0), port_of(options.domain, kMostOnAHost) - 1)};
  }
  return {ErrorCode::kIo, fmt::format("DDS: domain {} cannot be opened: {}", options.domain,
                                      heard.empty() ? dds_strretcode(-answer) : heard)};
}

/// What Cyclone answers is a word at most; what it said meanwhile is the reason.
Error with_reason(Error error, const std::string& heard) {
  if (!heard.empty()) error.text += ": " + heard;
  return error;
}

Result<Entity> make_domain(const DdsOptions& options, Log log) {
  const auto xml = domain_xml(options);
  const CycloneLog::Ear ear;
  const auto answer = dds_create_domain(options.domain, xml.c_str());
  if (answer > 0 && !ear.heard.empty()) log.warning(ear.heard);
  if (answer > 0) return Entity(answer);
  return fail(cannot_open(options, answer, ear.heard));
}

}  // namespace

DdsEcology::DdsEcology(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
DdsEcology::~DdsEcology() = default;

Result<std::unique_ptr<DdsEcology>> DdsEcology::open(DdsOptions options, Scheduler& scheduler, Post post,
                                                     base::LogSink& log) {
  if (auto good = check_interfaces(options, interfaces()); !good) return fail(std::move(good.error()));
  auto words = std::make_unique<CycloneLog>(scheduler, post, log);
  std::vector<std::string> unknown;
  options.peers = with_addresses(std::move(options.peers), scheduler, kResolving, unknown);
  for (const auto& peer : unknown) {
    Log(log, "dds")
        .warning(fmt::format(
            "tuples.peers: '{}' cannot be resolved: until the next start it has to find us, we do not look for it",
            peer));
  }
  auto domain = make_domain(options, Log(log, "dds"));
  if (!domain) return fail(std::move(domain.error()));
  return std::unique_ptr<DdsEcology>(new DdsEcology(std::make_unique<Impl>(
      Impl{std::move(options), scheduler, std::move(post), log, std::move(words), std::move(*domain)})));
}

Result<std::unique_ptr<Link>> DdsEcology::join(OwnerId id) {
  const CycloneLog::Ear ear;
  auto participant = made(dds_create_participant(impl_->options.domain, nullptr, nullptr),
                          fmt::format("participant of component {}", number(id)));
  if (!participant) return fail(with_reason(std::move(participant.error()), ear.heard));
  const auto displaced = [call = std::weak_ptr(impl_->displaced), id] {
    if (const auto told = call.lock(); told && *told) (*told)(id);
  };
  auto link = DdsLink::make(id, std::move(*participant), impl_->options, impl_->scheduler, impl_->post, displaced,
                            impl_->starts, impl_->log);
  if (!link) return fail(with_reason(std::move(link.error()), ear.heard));
  return std::move(*link);
}

std::vector<ComponentStart> DdsEcology::component_starts() const {
  return impl_->starts->all();
}

void DdsEcology::watch_displaced(std::function<void(OwnerId)> call) {
  *impl_->displaced = std::move(call);
}

}  // namespace rubicon::tuples::dds
