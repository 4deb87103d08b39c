#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <iterator>
#include <list>
#include <utility>

#include "base/log.h"
#include "client/ecology_options.h"
#include "client/message_client.h"
#include "client/points.h"
#include "client/remote_set_tracker.h"
#include "client/tuple_query.h"
#include "rubicon/client.hpp"
#include "transport/host_names.h"
#include "transport/poll_loop.h"
#include "tuples/peis/peis_ecology.h"
#include "tuples/peis/presence.h"
#include "tuples/peis/session.h"

namespace rubicon::client {

/// What the component of this process sees of its PEIS network.
PeisView view_of(const tuples::peis::PeisEcology& ecology);

namespace {

using tuples::peis::TroubleKind;

PeisTrouble::Kind kind_of(TroubleKind kind) {
  switch (kind) {
    case TroubleKind::kForeignNetwork: return PeisTrouble::Kind::kForeignNetwork;
    case TroubleKind::kForeignVersion: return PeisTrouble::Kind::kForeignVersion;
    case TroubleKind::kUnreachable: return PeisTrouble::Kind::kUnreachable;
    case TroubleKind::kOwnId: return PeisTrouble::Kind::kOwnId;
    case TroubleKind::kSharedId: return PeisTrouble::Kind::kSharedId;
  }
  return PeisTrouble::Kind::kUnreachable;
}

}  // namespace

PeisView view_of(const tuples::peis::PeisEcology& ecology) {
  PeisView view;
  const auto count = [&view](std::string_view name, std::uint64_t value) {
    if (value > 0) view.counters[std::string(name)] += value;
  };
  for (const auto* presence : ecology.presences()) {
    tuples::peis::each_counter(presence->counters(), count);
    const auto* node = presence->node();
    if (!node) continue;
    tuples::peis::each_counter(node->counters(), count);
    view.local = transport::to_string(node->local());
    view.connections += node->links().size();
    for (const auto& one : node->troubles())
      view.troubles.push_back({kind_of(one.kind), one.id, one.name, one.detail, one.times});
  }
  return view;
}

namespace {

/// How long a waiting call sleeps between two checks. A turn of the loop counts as two sleeps at most, so a stop of
/// this process or its host uses up little of the timeout.
Duration sleep_of(Duration timeout) {
  using namespace std::chrono_literals;
  return std::clamp<Duration>(timeout / 20, 10ms, 1s);
}

/// How long a command waits for an owner that is not present yet.
constexpr Duration kNamedOwner = std::chrono::seconds(3);

class CallSink final : public base::LogSink {
 public:
  explicit CallSink(std::function<void(std::string_view)> call) : call_(std::move(call)) {}
  void write(base::LogLevel level, std::string_view, std::string_view text) override {
    if (call_ && level >= base::LogLevel::kWarning) call_(text);
  }

 private:
  std::function<void(std::string_view)> call_;
};

std::unique_ptr<tuples::Link> joined(tuples::Ecology& ecology, OwnerId id, Error& error) {
  auto link = ecology.join(id);
  if (link) return std::move(*link);
  error = std::move(link.error());
  return nullptr;
}

}  // namespace

/// Members use those above them, so they are destroyed in reverse order.
struct Client::Impl {
  Impl(Options o, std::unique_ptr<transport::PollLoop> a_loop) : options(std::move(o)), loop(std::move(a_loop)) {}

  Result<void> join() {
    const auto post = [this](std::function<void()> call) { loop->post(std::move(call)); };
    options.id = component_id(options);
    if (const auto text = old_space_warning(options); !text.empty() && options.warn) options.warn(text);
    auto engines = engine_options(options);
    if (!engines) return fail(std::move(engines.error()));
    auto realm = open_realm(options, *loop, log);
    if (!realm) return fail(std::move(realm.error()));
    if (engines->mqtt) engines->mqtt->realm = std::move(*realm);
    if (engines->host) host_space = engines->host->space;
    auto opened = tuples::engines::Engines::open(
        *engines, {*loop, post, sockets, log, transport::netlink_interfaces(transport::poll_watch(*loop))});
    if (!opened) return fail(std::move(opened.error()));
    ecology = std::move(*opened);
    Error error;
    link = joined(*ecology, options.id, error);
    if (!link) return fail(std::move(error));
    space = std::make_unique<TupleSpace>(options.id, *loop, *link);
    pace = engines->peis ? kPeisPace : engines->dds ? kDdsPace : kHostPace;
    peer_discovery =
        std::make_unique<PeerDiscovery>(*loop, *space, pace, [this](auto owner) { return expects(owner); });
    Summary summary{options.name, transport::host_name(), transport::own_process(), "", loop->wall_now()};
    return space->describe(model::to_json(summary));
  }

  bool expects(std::optional<OwnerId> owner) const {
    const bool at_broker = ecology->mqtt() && ecology->mqtt()->seeks(owner);
    return at_broker || (ecology->dds() && ecology->dds()->expects_components()) ||
           (ecology->host() && !ecology->host()->knows_all());
  }

  MessageClient& office() {
    if (!message_client) message_client = std::make_unique<MessageClient>(*loop, *space, log);
    return *message_client;
  }

  /// Components, or processes of this host that have not said what components they have.
  TupleQuery::UnansweredCall warns_of_unanswered(Duration patience) {
    return [this, patience](const std::vector<OwnerId>& owners) {
      std::vector<std::string> all;
      for (const auto owner : owners) all.push_back(fmt::format("component {}", number(owner)));
      if (ecology->host()) std::ranges::move(ecology->host()->awaited(), std::back_inserter(all));
      if (all.empty()) return;
      limited_log.warning(
          "unanswered", fmt::format("{} has not answered within {} s: the result lacks its tuples{}", all.front(),
                                    std::chrono::duration<double>(patience).count(),
                                    all.size() > 1 ? fmt::format(", and the tuples of {} more", all.size() - 1) : ""));
    };
  }

  bool run_until(const std::function<bool()>& done, Duration timeout) const {
    const auto sleep = sleep_of(timeout);
    Duration gone{};
    for (auto before = loop->now();;) {
      loop->poll();
      if (done()) return true;
      const auto now = loop->now();
      gone += std::min(now - std::exchange(before, now), 2 * sleep);
      if (gone >= timeout) return false;
      loop->wait(std::min(timeout - gone, sleep));
    }
  }

  /// All present tuples that match one of the patterns. Blocks.
  std::vector<Tuple> read(const std::vector<Pattern>& patterns, Duration timeout,
                          const TupleQuery::Wanted& wanted = {}) {
    std::vector<Tuple> found;
    std::list<TupleQuery> under_way;
    auto left = patterns.size();
    const auto take = [&](std::vector<Tuple> some) {
      std::move(some.begin(), some.end(), std::back_inserter(found));
      --left;
    };
    for (const auto& pattern : patterns)
      under_way.emplace_back(*loop, *space, *peer_discovery, pattern, take, timeout, warns_of_unanswered(timeout),
                             wanted);
    run_until([&] { return left == 0; }, Duration::max());
    return found;
  }

  /// Owns a thing until it reports its end. It may do so while it runs, so it is destroyed in a later turn.
  template <class Thing, class Make>
  void keep(std::list<std::unique_ptr<Thing>>& things, Make make) {
    auto& place = things.emplace_back();
    place = make([this, &things, &place] {
      loop->post([&things, &place] { things.remove_if([&](const auto& one) { return &one == &place; }); });
    });
  }

  std::shared_ptr<Impl*> self = std::make_shared<Impl*>(this);
  Options options;
  CallSink log{options.warn};
  std::unique_ptr<transport::PollLoop> loop;
  base::LimitedLog limited_log{{log, "client"}, *loop};
  transport::PollSockets sockets{*loop};
  std::unique_ptr<tuples::engines::Engines> ecology;
  std::unique_ptr<tuples::Link> link;
  std::unique_ptr<TupleSpace> space;
  std::string host_space;
  DiscoveryPace pace = kDdsPace;
  std::unique_ptr<PeerDiscovery> peer_discovery;
  std::unique_ptr<MessageClient> message_client;
  std::list<std::unique_ptr<TupleQuery>> queries;
  std::list<std::unique_ptr<RemoteSetTracker>> set_trackers;
  std::atomic<bool> stopped = false;
};

Client::Client(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Client::~Client() = default;

Result<std::unique_ptr<Client>> Client::open(Options options) {
  if (auto good = check(options); !good) return fail(std::move(good.error()));
  if (options.name.empty()) options.name = "component";
  auto loop = transport::PollLoop::make();
  if (!loop) return fail(std::move(loop.error()));
  auto impl = std::make_unique<Impl>(std::move(options), std::move(*loop));
  if (auto joined_in = impl->join(); !joined_in) return fail(std::move(joined_in.error()));
  return std::unique_ptr<Client>(new Client(std::move(impl)));
}

OwnerId Client::id() const {
  return impl_->options.id;
}
TupleSpace& Client::tuples() {
  return *impl_->space;
}
base::Scheduler& Client::scheduler() {
  return *impl_->loop;
}
int Client::descriptor() const {
  return impl_->loop->descriptor();
}
void Client::poll() {
  impl_->loop->poll();
}

void Client::run() {
  std::ignore = run_until([this] { return impl_->stopped.exchange(false); }, Duration::max());
}

void Client::stop() {
  impl_->stopped = true;
  impl_->loop->wake();
}

bool Client::run_until(const std::function<bool()>& done, Duration timeout) {
  return impl_->run_until(done, timeout);
}

Handle Client::after(Duration delay, std::function<void()> call) {
  auto timer = std::make_shared<Timer>(impl_->loop->after(delay, std::move(call)));
  return Handle([timer] { timer->cancel(); });
}

std::vector<Component> Client::components() const {
  std::vector<Component> found;
  for (const auto id : impl_->space->peers()) {
    const auto text = impl_->space->summary(id);
    found.push_back({id, text.empty() ? Summary{} : model::summary_from_json(text).value_or(Summary{})});
  }
  return found;
}

std::optional<bool> Client::has(OwnerId id) const {
  return impl_->peer_discovery->has(id);
}

std::vector<Component> Client::islands() const {
  auto found = components();
  std::erase_if(found, [](const Component& one) { return !model::is_island(one.id, one.summary); });
  return found;
}

void Client::discover(Duration patience) {
  auto& discovery = *impl_->peer_discovery;
  const auto complete = [&discovery] { return discovery.complete(); };
  const auto ends = impl_->loop->now() + patience;
  for (auto now = ends - patience; now < ends && !complete(); now = impl_->loop->now())
    std::ignore = run_until(complete, std::min(discovery.complete_at(), ends) - now);
  impl_->warns_of_unanswered(patience)({});
}

std::vector<ComponentStart> Client::component_starts() const {
  std::vector<ComponentStart> all;
  if (!impl_->ecology->dds()) return all;
  for (const auto& one : impl_->ecology->dds()->component_starts()) {
    all.push_back(
        {one.id, one.incarnation, one.version, one.present, model::summary_from_json(one.summary).value_or(Summary{})});
  }
  return all;
}

std::size_t Client::silent_participants() const {
  const auto* dds = impl_->ecology->dds();
  return dds ? dds->silent_participants() : 0;
}

unsigned Client::protocol_version() {
  return tuples::dds::kProtocolVersion;
}

std::optional<HostView> Client::host_view() const {
  const auto* host = impl_->ecology->host();
  return host ? std::optional(HostView{host->folder().path(), impl_->host_space, host->awaited()}) : std::nullopt;
}

std::optional<PeisView> Client::peis_view() const {
  const auto* peis = impl_->ecology->peis();
  return peis ? std::optional(view_of(*peis)) : std::nullopt;
}

void Client::read(const Pattern& pattern, TuplesCall call, Duration timeout) {
  auto& impl = *impl_;
  impl.keep(impl.queries, [&](auto over) {
    auto finished = [call = std::move(call), over](std::vector<Tuple> tuples) {
      over();
      call(std::move(tuples));
    };
    return std::make_unique<TupleQuery>(*impl.loop, *impl.space, *impl.peer_discovery, pattern, std::move(finished),
                                        timeout, impl.warns_of_unanswered(timeout));
  });
}

std::vector<Tuple> Client::read(const Pattern& pattern, Duration timeout) {
  return impl_->read({pattern}, timeout);
}

Result<void> Client::read_points(const Pattern& points, PointsCall call, Duration timeout) {
  const auto patterns = point_patterns(points);
  if (!patterns) return fail(patterns.error());
  struct Gathering {
    std::vector<Tuple> tuples;
    std::size_t left;
    PointsCall call;
  };
  const auto all = patterns->all();
  const auto gathering = std::make_shared<Gathering>(Gathering{{}, all.size(), std::move(call)});
  for (const auto* pattern : all) {
    read(
        *pattern,
        [gathering](std::vector<Tuple> some) {
          std::move(some.begin(), some.end(), std::back_inserter(gathering->tuples));
          if (--gathering->left == 0) gathering->call(points_from(gathering->tuples));
        },
        timeout);
  }
  return {};
}

Result<std::vector<Point>> Client::read_points(const Pattern& points, Duration timeout) {
  const auto found = std::make_shared<std::optional<std::vector<Point>>>();
  auto begun = read_points(
      points, [found](std::vector<Point> some) { *found = std::move(some); }, timeout);
  if (!begun) return fail(std::move(begun.error()));
  run_until([&] { return found->has_value(); }, Duration::max());
  return std::move(**found);
}

Result<Handle> Client::watch_points(const Pattern& points, const Flow& flow, PointCall call) {
  const auto patterns = point_patterns(points);
  if (!patterns) return fail(patterns.error());
  auto watch = std::make_shared<std::unique_ptr<PointWatch>>(
      std::make_unique<PointWatch>(*impl_->loop, *impl_->space, *patterns, flow, std::move(call)));
  // The handle may be destroyed within a call of the watch.
  return Handle([watch, self = std::weak_ptr(impl_->self)] {
    if (const auto impl = self.lock()) (*impl)->loop->post([watch] { watch->reset(); });
  });
}

std::vector<Network> Client::networks(std::optional<OwnerId> island, Duration timeout) {
  const auto any_network = model::IslandKey{"*"}.network("*");
  return networks_from(impl_->read(
      {{island, any_network.status()}, {island, any_network.device("*").status()}, {island, any_network.property("*")}},
      timeout));
}

Handle Client::watch_devices(const DeviceQuery& query, DeviceCall call) {
  auto watch = std::make_shared<std::unique_ptr<DeviceWatch>>(
      std::make_unique<DeviceWatch>(*impl_->space, query, std::move(call)));
  // The handle may be destroyed within a call of the watch.
  return Handle([watch, self = std::weak_ptr(impl_->self)] {
    if (const auto impl = self.lock()) (*impl)->loop->post([watch] { watch->reset(); });
  });
}

std::vector<Device> Client::devices(const DeviceQuery& query, Duration timeout) {
  constexpr std::size_t kFew = 64;  // whose statuses are read one by one
  const auto any_network = model::IslandKey{"*"}.network("*");
  const auto any_device = any_network.device("*");
  const auto may_be_wanted = [&query](const auto& tuple) { return may_fit(query, tuple.key, tuple.value); };
  auto found =
      described_devices(impl_->read({{query.island, any_device.description()}}, timeout, may_be_wanted), query);
  std::vector<Pattern> states{{query.island, any_network.status()}};
  if (found.size() > kFew) {
    states.push_back({query.island, any_device.status()});
  } else {
    for (const auto& device : found) states.push_back({device.island, model::DeviceKey{device.key()}.status()});
  }
  add_states(found, impl_->read(states, timeout));
  std::sort(found.begin(), found.end(), listed_before);
  return found;
}

void Client::command(OwnerId owner, std::string_view key, std::string_view value, OutcomeCall ended,
                     Duration time_to_live, Duration timeout, OutcomeCall progress) {
  auto& impl = *impl_;
  impl.keep(impl.set_trackers, [&](auto over) {
    auto finished = [ended = std::move(ended), over](const Outcome& outcome) {
      over();
      if (ended) ended(outcome);
    };
    return std::make_unique<RemoteSetTracker>(*impl.loop, *impl.space, owner, key, value, std::move(finished),
                                              time_to_live, timeout, std::move(progress));
  });
}

Outcome Client::command(OwnerId owner, std::string_view key, std::string_view value, Duration time_to_live,
                        Duration timeout, OutcomeCall progress) {
  run_until([&] { return has(owner).has_value(); }, std::min(timeout, kNamedOwner));
  std::optional<Outcome> outcome;
  const RemoteSetTracker errand(
      *impl_->loop, *impl_->space, owner, key, value, [&](const Outcome& final) { outcome = final; }, time_to_live,
      timeout, std::move(progress));
  run_until([&] { return outcome.has_value(); }, Duration::max());
  return *outcome;
}

void Client::send(OwnerId to, std::string_view type, std::string_view bytes, SentCall sent) {
  impl_->office().send({to, {}, {}}, type, bytes, std::move(sent));
}

void Client::send_to_network(OwnerId island, std::string_view network, std::string_view type, std::string_view bytes,
                             SentCall sent) {
  impl_->office().send({island, std::string(network), {}}, type, bytes, std::move(sent));
}

void Client::send_to_device(OwnerId island, std::string_view network, std::string_view address, std::string_view type,
                            std::string_view bytes, SentCall sent) {
  impl_->office().send({island, std::string(network), std::string(address)}, type, bytes, std::move(sent));
}

Handle Client::on_message(std::string_view type, MessageCall call) {
  return impl_->office().on_message(type, std::move(call));
}

}  // namespace rubicon::client
