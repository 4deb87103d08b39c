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
  std::unique_ptr<CycloneLog> cyclone_log;  // outlives the domain, which may log when it is deleted
  Entity domain;
  std::shared_ptr<ComponentStarts> starts = std::make_shared<ComponentStarts>();
  std::shared_ptr<std::function<void(OwnerId)>> displaced = std::make_shared<std::function<void(OwnerId)>>();
};

namespace {

/// Time for resolving host names at the start.
constexpr Duration kResolveTimeout = std::chrono::seconds(5);

/// kBusy or kIo, the text says what to do where that is known.
Error cannot_open(const DdsOptions& options, dds_return_t code, const std::string& messages) {
  if (code == DDS_RETCODE_PRECONDITION_NOT_MET)
    return {ErrorCode::kBusy, fmt::format("DDS domain {} is open in this process already", options.domain)};
  if (messages.find("free participant index") != messages.npos) {
    return {ErrorCode::kIo,
            fmt::format("DDS: domain {} has no room for one more process on this host: {} run already (UDP ports {} to "
                        "{} are taken). End some of them, or use another tuples.domain",
                        options.domain, kMaxProcessesPerHost, port_of(options.domain, 0),
                        port_of(options.domain, kMaxProcessesPerHost) - 1)};
  }
  return {ErrorCode::kIo, fmt::format("DDS: domain {} cannot be opened: {}", options.domain,
                                      messages.empty() ? dds_strretcode(-code) : messages)};
}

/// Appends the messages of Cyclone, which explain its return code.
Error with_reason(Error error, const std::string& messages) {
  if (!messages.empty()) error.text += ": " + messages;
  return error;
}

Result<Entity> make_domain(const DdsOptions& options, Log log) {
  const auto xml = domain_xml(options);
  const CycloneLog::Capture capture;
  const auto code = dds_create_domain(options.domain, xml.c_str());
  if (code > 0 && !capture.text.empty()) log.warning(capture.text);
  if (code > 0) return Entity(code);
  return fail(cannot_open(options, code, capture.text));
}

}  // namespace

DdsEcology::DdsEcology(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
DdsEcology::~DdsEcology() = default;

Result<std::unique_ptr<DdsEcology>> DdsEcology::open(DdsOptions options, Scheduler& scheduler, Post post,
                                                     base::LogSink& log) {
  if (auto good = check_interfaces(options, transport::interfaces()); !good) return fail(std::move(good.error()));
  auto cyclone_log = std::make_unique<CycloneLog>(scheduler, post, log);
  std::vector<std::string> unknown;
  options.peers = with_addresses(std::move(options.peers), scheduler, kResolveTimeout, unknown);
  for (const auto& peer : unknown) {
    Log(log, "dds")
        .warning(fmt::format("tuples.peers: '{}' cannot be resolved: this process does not search for it until the "
                             "next start, but it may "
                             "find this process",
                             peer));
  }
  auto domain = make_domain(options, Log(log, "dds"));
  if (!domain) return fail(std::move(domain.error()));
  return std::unique_ptr<DdsEcology>(new DdsEcology(std::make_unique<Impl>(
      Impl{std::move(options), scheduler, std::move(post), log, std::move(cyclone_log), std::move(*domain)})));
}

Result<std::unique_ptr<Link>> DdsEcology::join(OwnerId id) {
  return join_as({id, {}, [call = std::weak_ptr(impl_->displaced), id] {
                    if (const auto listener = call.lock(); listener && *listener) (*listener)(id);
                  }});
}

Result<std::unique_ptr<Link>> DdsEcology::join_as(StandIn who) {
  const CycloneLog::Capture capture;
  auto participant = made(dds_create_participant(impl_->options.domain, nullptr, nullptr),
                          fmt::format("participant of component {}", number(who.id)));
  if (!participant) return fail(with_reason(std::move(participant.error()), capture.text));
  auto link = DdsLink::make(std::move(who), std::move(*participant), impl_->options, impl_->scheduler, impl_->post,
                            impl_->starts, impl_->log);
  if (!link) return fail(with_reason(std::move(link.error()), capture.text));
  return std::move(*link);
}

std::vector<ComponentStart> DdsEcology::component_starts() const {
  return impl_->starts->all();
}

void DdsEcology::watch_displaced(std::function<void(OwnerId)> call) {
  *impl_->displaced = std::move(call);
}

}  // namespace rubicon::tuples::dds
