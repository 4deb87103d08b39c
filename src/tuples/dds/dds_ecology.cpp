#include "tuples/dds/dds_ecology.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <set>

#include "base/clocks.h"
#include "base/log.h"
#include "tuples/dds/dds_link.h"
#include "tuples/dds/dds_options.h"
#include "tuples/dds/dds_threads.h"
#include "tuples/dds/entity.h"
#include "tuples/dds/moves.h"
#include "tuples/peer_policy.h"

namespace rubicon::tuples::dds {

struct DdsEcology::Impl {
  Impl(DdsOptions options, Scheduler& scheduler, Post post, base::LogSink& sink, std::function<Duration()> since_boot)
      : shared{std::move(options), scheduler, std::move(post), sink, std::move(since_boot)},
        log(sink, "dds"),
        limited_log(log, scheduler) {
    shared.overrun = [this] { overrun(); };
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  Result<void> enter();
  Result<Entity> make_participant(OwnerId id);
  [[nodiscard]] FormerDomain::Remains leave_behind();
  /// Of the domain in this process: a former one with the same number may not be deleted yet.
  dds_domainid_t number_here() const { return shared.options.domain + 256 * generation; }
  Result<void> bring_back(DdsLink& link);
  Result<void> come_back();
  void overrun();
  void watch_clock();
  template <class Call>
  void each_link(Call call);

  LinkShared shared;
  Log log;
  base::LimitedLog limited_log;
  std::unique_ptr<CycloneLog> cyclone_log;  // outlives the domain, which may log when it is deleted
  Entity domain;
  dds_domainid_t generation = 0;
  Moves moves{shared.options.interfaces,
              shared.scheduler,
              shared.post,
              log,
              {[this] { return leave_behind(); }, [this] { return come_back(); }}};
  std::shared_ptr<std::function<void(OwnerId)>> displaced = std::make_shared<std::function<void(OwnerId)>>();
  Timer clock_timer;
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

/// `number`: that of the domain in this process.
Result<Entity> make_domain(const DdsOptions& options, dds_domainid_t number, Log log) {
  const auto xml = domain_xml(options);
  const CycloneLog::Capture capture;
  const auto code = dds_create_domain(number, xml.c_str());
  if (code > 0 && !capture.text.empty()) log.warning(capture.text);
  if (code > 0) return Entity(code);
  return fail(cannot_open(options, code, capture.text));
}

/// Between looks at a clock that was not set.
constexpr Duration kClockPause = std::chrono::seconds(5);
/// Outside, after others made DDS keep too much.
constexpr Duration kRest = std::chrono::seconds(5);

}  // namespace

/// With the interfaces that the host has now.
Result<void> DdsEcology::Impl::enter() {
  auto here = shared.options;
  here.interfaces = moves.take(transport::interfaces());
  if (here.interfaces.empty())
    return fail(ErrorCode::kIo, "DDS: no interface of tuples.interfaces can be used: none is up with an IPv4 address");
  auto made_domain = make_domain(here, number_here(), log);
  if (!made_domain) return fail(std::move(made_domain.error()));
  domain = std::move(*made_domain);
  return {};
}

Result<Entity> DdsEcology::Impl::make_participant(OwnerId id) {
  const CycloneLog::Capture capture;
  auto participant = made(dds_create_participant(number_here(), nullptr, nullptr),
                          fmt::format("participant of component {}", number(id)));
  if (!participant) return fail(with_reason(std::move(participant.error()), capture.text));
  return participant;
}

/// A call may end links.
template <class Call>
void DdsEcology::Impl::each_link(Call call) {
  for (auto* link : std::set(shared.links)) {
    if (shared.links.contains(link)) call(*link);
  }
}

FormerDomain::Remains DdsEcology::Impl::leave_behind() {
  FormerDomain::Remains remains;
  if (domain) each_link([&](DdsLink& link) { link.leave_behind(remains); });
  remains.domain = std::move(domain);
  ++generation;
  return remains;
}

Result<void> DdsEcology::Impl::bring_back(DdsLink& link) {
  auto participant = make_participant(link.id());
  if (!participant) return fail(std::move(participant.error()));
  return link.resume(std::move(*participant));
}

Result<void> DdsEcology::Impl::come_back() {
  if (auto entered = enter(); !entered) return entered;
  Result<void> all;
  each_link([&](DdsLink& link) {
    if (all) all = bring_back(link);
  });
  return all;
}

/// A peer that makes DDS keep so much may continue: the pause bounds the cost.
void DdsEcology::Impl::overrun() {
  limited_log.error("overrun", fmt::format("a program on the network ends more than {} keys and does not unregister "
                                           "them: this process leaves the ecology for a few seconds to be rid of them",
                                           EndedInstances::kMaxKept));
  moves.move_anyway(kRest);
}

/// Others ignore components that started before the clock of their host was set. When it is set, the links enter again,
/// and their starts count from then.
void DdsEcology::Impl::watch_clock() {
  clock_timer = shared.scheduler.after(kClockPause, [this] {
    if (!DeclaredHostPolicy::check_clock(shared.scheduler.wall_now())) return watch_clock();
    log.info("the clock of this host was set: the components of this process enter the ecology again");
    moves.move_anyway(Duration(0));
  });
}

DdsEcology::DdsEcology(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
DdsEcology::~DdsEcology() = default;

Result<std::unique_ptr<DdsEcology>> DdsEcology::open(DdsOptions options, Scheduler& scheduler, Post post,
                                                     base::LogSink& log, std::function<Duration()> since_boot) {
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
  if (auto good = DeclaredHostPolicy::check_clock(scheduler.wall_now()); !good)
    Log(log, "dds").warning(good.error().text);
  auto impl = std::make_unique<Impl>(std::move(options), scheduler, std::move(post), log, std::move(since_boot));
  impl->cyclone_log = std::move(cyclone_log);
  if (auto entered = impl->enter(); !entered) return fail(std::move(entered.error()));
  return std::unique_ptr<DdsEcology>(new DdsEcology(std::move(impl)));
}

Result<std::unique_ptr<Link>> DdsEcology::join(OwnerId id) {
  return join_as({id, {}, [call = std::weak_ptr(impl_->displaced), id] {
                    if (const auto listener = call.lock(); listener && *listener) (*listener)(id);
                  }});
}

Result<std::unique_ptr<Link>> DdsEcology::join_as(StandIn who) {
  if (!DeclaredHostPolicy::check_clock(impl_->shared.scheduler.wall_now())) impl_->watch_clock();
  auto participant = impl_->domain ? impl_->make_participant(who.id) : Entity();
  if (!participant) return fail(std::move(participant.error()));
  const CycloneLog::Capture capture;
  auto link = DdsLink::make(std::move(who), std::move(*participant), impl_->shared);
  if (!link) return fail(with_reason(std::move(link.error()), capture.text));
  return std::move(*link);
}

void DdsEcology::enter_again() {
  impl_->moves.move_anyway(Duration(0));
}

void DdsEcology::follow(const transport::WatchInterfaces& watch) {
  if (!is_loopback_only(impl_->shared.options)) impl_->moves.follow(watch);
}

const InterfaceNews& DdsEcology::interfaces() const {
  return impl_->moves.news();
}

bool DdsEcology::expects_components() const {
  const auto& links = impl_->shared.links;
  return std::any_of(links.begin(), links.end(), [](const auto* link) { return link->expects_presence(); });
}

std::vector<ComponentStart> DdsEcology::component_starts() const {
  return impl_->shared.starts->all();
}

std::size_t DdsEcology::silent_participants() const {
  std::set<Participant> all, known;
  for (const auto* link : impl_->shared.links) {
    all.merge(participants_in_domain(link->participant()));
    known.merge(link->participants_with_components());
  }
  return static_cast<std::size_t>(
      std::count_if(all.begin(), all.end(), [&](const auto& one) { return !known.contains(one); }));
}

void DdsEcology::watch_displaced(std::function<void(OwnerId)> call) {
  *impl_->displaced = std::move(call);
}

}  // namespace rubicon::tuples::dds
