#include "tuples/dds/dds_ecology.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <set>

#include "base/limited_log.h"
#include "base/local_time.h"
#include "tuples/dds/cyclone_log.h"
#include "tuples/dds/dds_link.h"
#include "tuples/dds/entity.h"
#include "tuples/dds/heard_lists.h"
#include "tuples/dds/host.h"
#include "tuples/dds/refusals.h"
#include "tuples/dds/secure_participant.h"
#include "tuples/dds/shield.h"
#include "tuples/dds/silent_participants.h"
#include "tuples/host_policy.h"
#include "tuples/member_ids.h"

namespace rubicon::tuples::dds {

struct DdsEcology::Impl {
  Impl(DdsOptions options, Scheduler& scheduler, Post post, base::LogSink& sink, std::function<Duration()> since_boot)
      : shared{std::move(options), scheduler, std::move(post), sink, std::move(since_boot)},
        log(sink, "dds"),
        limited_log(log, scheduler) {
    if (!shared.options.trust) return;
    shield.emplace(shared.options.trust);
    if (!Shield::is_first())
      log.warning(
          "DDS: this program loads libddsc before Rubicon: packets of strangers can end members in it. Link librubicon "
          "before libddsc");
    shared.known_later = [this] { enter_again(Duration(0)); };
    shared.identities = std::make_shared<Identities>(shared.options.trust);
    shared.catch_up = std::make_shared<CatchUp>(scheduler, shared.options.lease);
    shared.heard_revoked = [this](const std::string& member, std::string_view list) { hear_revoked(member, list); };
    shared.options.trust->watch_revoked([this] { renounce(); });
    shared.options.trust->watch_refused([this](const DdsTrust::Refusal& refusal) { refusals.take(refusal); });
    shared.refused_peers = [this] { return refusals.peers(); };
  }
  ~Impl() {
    if (!shared.options.trust) return;
    shared.options.trust->watch_revoked({});
    shared.options.trust->watch_refused({});
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  Result<void> enter();
  Result<Entity> make_participant(OwnerId id);
  Result<void> may_join(OwnerId id) const;
  Result<bool> renew();
  void leave();
  Result<void> bring_back(DdsLink& link);
  Result<void> come_back();
  void retry();
  void enter_again(Duration pause);
  void watch_end();
  void watch_clock();
  void hear_revoked(const std::string& member, std::string_view signed_list);
  void check_revoked(std::string list, const std::string& member);
  void renounce();
  template <class Call>
  void each_link(Call call);

  DdsLink::Shared shared;
  std::optional<Shield> shield;  ///< outlives the domain
  Log log;
  base::LimitedLog limited_log;
  std::unique_ptr<CycloneLog> cyclone_log;  // outlives the domain, which may log when it is deleted
  DdsTrust::Documents documents;            ///< those that the domain was made with
  Member own;                               ///< by them
  Entity domain;
  std::shared_ptr<std::function<void(OwnerId)>> displaced = std::make_shared<std::function<void(OwnerId)>>();
  std::set<std::string, std::less<>> lists_refused;  ///< the last lists of revoked certificates that were of no use
  HeardLists lists_heard{shared.scheduler, [this](std::string list, const std::string& member) {
                           check_revoked(std::move(list), member);
                         }};
  Refusals refusals{shared.scheduler, shared.post, shared.log};
  Timer end_timer, retry_timer, again_timer, clock_timer;
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

Error ended(const Member& own) {
  return {ErrorCode::kExpired, fmt::format("the certificate of '{}' ended at {}", own.name,
                                           base::utc_text(own.expires, "%Y-%m-%dT%H:%M:%SZ"))};
}

bool has_end(const Member& own) {
  return own.expires != WallTime{};
}

/// Pause before trying again to enter the domain.
constexpr Duration kRetryPause = std::chrono::seconds(5);
/// A member that is revoked reads what it read, presence and subscriptions, until the domain is made again. The list
/// reaches the others before.
constexpr Duration kSpread = std::chrono::seconds(1);
/// The clock of the wall may be set meanwhile.
constexpr Duration kLongestWatch = std::chrono::seconds(60);
constexpr std::size_t kMaxListsRefused = 16;

}  // namespace

/// The documents first: their errors name a file.
Result<void> DdsEcology::Impl::enter() {
  if (shared.options.trust) {
    auto read = shared.options.trust->documents();
    if (!read) return fail(std::move(read.error()));
    documents = std::move(*read);
    own = shared.options.trust->own();
    if (has_end(own) && own.expires <= shared.scheduler.wall_now()) return fail(ended(own));
  }
  auto made_domain = make_domain(shared.options, log);
  if (!made_domain) return fail(std::move(made_domain.error()));
  domain = std::move(*made_domain);
  return {};
}

Result<Entity> DdsEcology::Impl::make_participant(OwnerId id) {
  const auto& trust = shared.options.trust;
  const auto qos = trust ? make_secure_qos(documents, trust->guard_library()) : Qos();
  const CycloneLog::Capture capture;
  auto participant = made(dds_create_participant(shared.options.domain, qos.get(), nullptr),
                          fmt::format("participant of component {}", number(id)));
  if (!participant) return fail(with_reason(std::move(participant.error()), capture.text));
  if (shared.identities) shared.identities->add_own(prefix_of_own(participant->get()));
  return participant;
}

Result<void> DdsEcology::Impl::may_join(OwnerId id) const {
  if (!shared.options.trust) return {};
  if (own.may_use(id)) return {};
  return fail(ErrorCode::kRefused,
              fmt::format("component {} (hexadecimal {}) cannot take part: the certificate of '{}' has the ids {}",
                          number(id), hex_id(id), own.name, text_of_ids(own)));
}

/// A call may end links.
template <class Call>
void DdsEcology::Impl::each_link(Call call) {
  for (auto* link : std::set(shared.links)) {
    if (shared.links.contains(link)) call(*link);
  }
}

void DdsEcology::Impl::leave() {
  end_timer.cancel();
  each_link([](DdsLink& link) { link.suspend(); });
  domain.reset();
  if (shared.identities) shared.identities->clear_own();
}

Result<bool> DdsEcology::Impl::renew() {
  const auto& trust = shared.options.trust;
  if (!trust) return false;
  const auto revoked = trust->revoked();
  auto read = trust->documents();
  const bool is_same = domain && read && !read->contents.empty() && read->contents == documents.contents;
  if (domain && (!read || is_same) && trust->revoked() != revoked) renounce();
  if (!read) return fail(std::move(read.error()));
  if (is_same) return false;
  retry_timer.cancel();
  again_timer.cancel();
  leave();
  auto done = come_back();
  if (!done) retry();
  if (!done) return fail(std::move(done.error()));
  return true;
}

Result<void> DdsEcology::Impl::bring_back(DdsLink& link) {
  if (auto may = may_join(link.id()); !may) return may;
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
  if (all) watch_end();
  if (!all) leave();
  return all;
}

void DdsEcology::Impl::retry() {
  retry_timer = shared.scheduler.after(kRetryPause, [this] {
    const auto done = come_back();
    if (done && shared.catch_up) shared.catch_up->begin();
    if (done) return log.info("this process is in the ecology again");
    limited_log.error("outside", done.error().text);
    retry();
  });
}

/// Others are lost for half a second, as in a renewal. With a file that cannot be read now this process could not come
/// back: it stays until the file is there again. If it was revoked itself, it leaves.
void DdsEcology::Impl::enter_again(Duration pause) {
  if (again_timer.pending()) return;
  again_timer = shared.scheduler.after(pause, [this] {
    if (!domain) return;
    const auto& trust = shared.options.trust;
    if (const auto read = trust ? trust->documents() : DdsTrust::Documents{}; !read && !trust->is_revoked()) {
      limited_log.error("documents", read.error().text + "; this process goes on with what it has read before");
      return enter_again(kRetryPause);
    }
    leave();
    if (const auto done = come_back(); !done) {
      limited_log.error("outside", done.error().text);
      retry();
    }
  });
}

/// Cyclone does not tell: others lose this process at that second, and its writers go on as if nothing was. It comes
/// back by itself with a new certificate, and if it was the clock that was wrong.
void DdsEcology::Impl::watch_end() {
  if (!shared.options.trust || !has_end(own)) return;
  const Duration left = own.expires - shared.scheduler.wall_now();
  if (left > Duration(0)) {
    each_link([](DdsLink& link) { link.forget_members(); });  // theirs may have ended, also because the clock was set
    end_timer = shared.scheduler.after(std::min(left, kLongestWatch), [this] { watch_end(); });
    return;
  }
  log.error(fmt::format("{}: this process left the ecology. Renew it (rubicon trust dds renew {})", ended(own).text,
                        own.name));
  leave();
  retry();
}

/// Others ignore components that started before the clock of their host was set. When it is set, the links enter again,
/// and their starts count from then.
void DdsEcology::Impl::watch_clock() {
  clock_timer = shared.scheduler.after(kRetryPause, [this] {
    if (!HostPolicy::check_clock(shared.scheduler.wall_now())) return watch_clock();
    log.info("the clock of this host was set: the components of this process enter the ecology again");
    enter_again(Duration(0));
  });
}

void DdsEcology::Impl::hear_revoked(const std::string& member, std::string_view signed_list) {
  if (signed_list == shared.options.trust->revoked() || lists_refused.contains(signed_list)) return;
  lists_heard.hear(member, signed_list);
}

void DdsEcology::Impl::check_revoked(std::string list, const std::string& member) {
  if (shared.options.trust->take_revoked(list, member)) return renounce();
  if (lists_refused.size() >= kMaxListsRefused) lists_refused.clear();
  lists_refused.insert(std::move(list));
}

void DdsEcology::Impl::renounce() {
  lists_refused.clear();
  bool some_lost = false;
  each_link([&](DdsLink& link) { some_lost |= link.renounce(); });
  const auto& trust = *shared.options.trust;
  if (some_lost || trust.meets_revoked() || trust.is_revoked()) enter_again(kSpread);
}

DdsEcology::DdsEcology(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
DdsEcology::~DdsEcology() = default;

Result<std::unique_ptr<DdsEcology>> DdsEcology::open(DdsOptions options, Scheduler& scheduler, Post post,
                                                     base::LogSink& log, std::function<Duration()> since_boot) {
  if (auto good = check_interfaces(options, transport::interfaces()); !good) return fail(std::move(good.error()));
  auto cyclone_log = std::make_unique<CycloneLog>(scheduler, post, log, options.trust != nullptr);
  std::vector<std::string> unknown;
  options.peers = with_addresses(std::move(options.peers), scheduler, kResolveTimeout, unknown);
  for (const auto& peer : unknown) {
    Log(log, "dds")
        .warning(fmt::format("tuples.peers: '{}' cannot be resolved: this process does not search for it until the "
                             "next start, but it may "
                             "find this process",
                             peer));
  }
  if (auto good = HostPolicy::check_clock(scheduler.wall_now()); !good) Log(log, "dds").warning(good.error().text);
  auto impl = std::make_unique<Impl>(std::move(options), scheduler, std::move(post), log, std::move(since_boot));
  impl->cyclone_log = std::move(cyclone_log);
  if (auto entered = impl->enter(); !entered) return fail(std::move(entered.error()));
  impl->watch_end();
  return std::unique_ptr<DdsEcology>(new DdsEcology(std::move(impl)));
}

Result<std::unique_ptr<Link>> DdsEcology::join(OwnerId id) {
  return join_as({id, {}, [call = std::weak_ptr(impl_->displaced), id] {
                    if (const auto listener = call.lock(); listener && *listener) (*listener)(id);
                  }});
}

Result<std::unique_ptr<Link>> DdsEcology::join_as(StandIn who) {
  if (auto may = impl_->may_join(who.id); !may) return fail(std::move(may.error()));
  if (!HostPolicy::check_clock(impl_->shared.scheduler.wall_now())) impl_->watch_clock();
  if (!impl_->domain) return fail(ErrorCode::kIo, "DDS: this process is outside of the ecology at the moment");
  auto participant = impl_->make_participant(who.id);
  if (!participant) return fail(std::move(participant.error()));
  const CycloneLog::Capture capture;
  auto link = DdsLink::make(std::move(who), std::move(*participant), impl_->shared);
  if (!link) return fail(with_reason(std::move(link.error()), capture.text));
  return std::move(*link);
}

Result<bool> DdsEcology::renew() {
  return impl_->renew();
}

bool DdsEcology::expects_components() const {
  const auto& links = impl_->shared.links;
  return std::any_of(links.begin(), links.end(), [](const auto* link) { return link->expects_presence(); });
}

std::vector<ComponentStart> DdsEcology::component_starts() const {
  return impl_->shared.starts->all();
}

std::size_t DdsEcology::silent_participants() const {
  std::set<GuidPrefix> all, known;
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
