#include "bridges/ros2/node.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "bridges/ros2/names.h"
#include "transport/interfaces.h"
#include "tuples/dds/dds_threads.h"

namespace rubicon::bridges::ros2 {

using tuples::dds::made;

/// Lives until the last posted call ran. What Cyclone's threads touch is below the mutex.
struct News::Shared : std::enable_shared_from_this<News::Shared> {
  Shared(Scheduler& loop, std::function<void(dds_entity_t)> to) : scheduler(loop), call(std::move(to)) {}

  void raise(dds_entity_t entity) {
    {
      const std::lock_guard lock(mutex);
      const bool pending = !entities.empty();
      entities.insert(entity);
      if (pending) return;
    }
    scheduler.post([self = shared_from_this()] { self->run(); });
  }
  void run() {
    std::set<dds_entity_t> all;
    {
      const std::lock_guard lock(mutex);
      all.swap(entities);
    }
    for (const auto entity : all) {
      if (const auto wake = call) wake(entity);
    }
  }

  Scheduler& scheduler;
  std::function<void(dds_entity_t)> call;  ///< of the loop's thread
  std::mutex mutex;
  std::set<dds_entity_t> entities;
};

News::News(Scheduler& scheduler, std::function<void(dds_entity_t)> call)
    : shared_(std::make_shared<Shared>(scheduler, std::move(call))), listener_(dds_create_listener(shared_.get())) {
  dds_lset_data_available(listener_.get(),
                          [](dds_entity_t entity, void* shared) { static_cast<Shared*>(shared)->raise(entity); });
  dds_lset_publication_matched(listener_.get(), [](dds_entity_t entity, const dds_publication_matched_status_t,
                                                   void* shared) { static_cast<Shared*>(shared)->raise(entity); });
}

News::~News() {
  shared_->call = nullptr;
}

namespace {

constexpr Duration kInfoPause = std::chrono::milliseconds(200);
/// Numbers of domains inside this process: those of the ecology are below 231, or 256 and more above (docs/ros2.md).
constexpr dds_domainid_t kFirstInside = 231, kInsideStep = 256;

dds_domainid_t next_inside() {
  static dds_domainid_t next = kFirstInside;
  return std::exchange(next, next + kInsideStep);
}

/// What Cyclone DDS prefers where no interface is named: multicast, and anything before loopback.
int preference(const transport::Interface& one) {
  return !one.is_up || one.address.empty() ? 0 : one.is_loopback ? 1 : one.has_multicast ? 3 : 2;
}

/// What the interfaces that we use are now: another text = they changed. One that was unplugged comes back with another
/// index, and without our multicast groups.
std::string addresses_of(const Reach& reach) {
  const auto present = transport::interfaces();
  const auto text = [](const auto& one) { return fmt::format("{}={}@{};", one.name, one.address, one.index); };
  std::string all;
  for (const auto& one : present) {
    if (std::count(reach.interfaces.begin(), reach.interfaces.end(), one.name) > 0 && one.is_up) all += text(one);
  }
  const auto best = std::max_element(present.begin(), present.end(), [](const auto& left, const auto& right) {
    return preference(left) < preference(right);
  });
  const bool takes_any = reach.interfaces.empty() && best != present.end() && preference(*best) > 0;
  return takes_any ? text(*best) : all;
}

Result<void> check_interfaces(const Reach& reach) {
  const auto present = transport::interfaces();
  for (const auto& name : reach.interfaces) {
    const auto found = std::find_if(present.begin(), present.end(), [&](const auto& one) { return one.name == name; });
    const char* lack = found == present.end()   ? "there is no such interface"
                       : !found->is_up          ? "it is down"
                       : found->address.empty() ? "it has no IPv4 address"
                                                : nullptr;
    if (lack != nullptr) return fail(ErrorCode::kIo, fmt::format("interface '{}': {}", name, lack));
  }
  return {};
}

tuples::dds::Qos qos_of(bool reliable, bool kept, int depth) {
  auto qos = tuples::dds::make_qos();
  dds_qset_reliability(qos.get(), reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT, 0);
  dds_qset_durability(qos.get(), kept ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, depth);
  dds_qset_writer_data_lifecycle(qos.get(), false);
  if (kept)
    dds_qset_durability_service(qos.get(), 0, DDS_HISTORY_KEEP_LAST, depth, DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED,
                                DDS_LENGTH_UNLIMITED);
  return qos;
}

tuples::dds::Qos qos_of(Keep keep) {
  return keep == Keep::kState ? qos_of(true, true, 1) : qos_of(true, false, 10);
}

Guid guid_of(dds_entity_t entity) {
  return tuples::dds::participant_of(entity);
}

}  // namespace

Node::Node(const BridgeHost& host, const Options& options, std::string name, Callbacks calls)
    : options_(options),
      name_(std::move(name)),
      callbacks_(std::move(calls)),
      news_(host.scheduler, [this](dds_entity_t entity) { news_of(entity); }),
      addresses_(addresses_of(options.reach)),
      graph_({}, [] {}),
      tell_(host.scheduler, kInfoPause, [this] { say_who_we_are(); }) {}

/// Endpoints of others must be gone by now; after that no listener runs.
Node::~Node() {
  info_.reset();
  for (auto* one :
       {&participants_, &publications_, &subscriptions_, &publisher_, &subscriber_, &participant_, &domain_})
    one->reset();
}

Result<std::unique_ptr<Node>> Node::open(const BridgeHost& host, const Options& options, std::string name,
                                         Callbacks calls) {
  if (auto good = check_interfaces(options.reach); !good) return fail(good.error());
  std::unique_ptr<Node> node(new Node(host, options, std::move(name), std::move(calls)));
  const tuples::dds::CycloneLog::Capture capture;
  auto entered = node->enter();
  if (entered) entered = node->look();
  if (entered) return node;
  const auto& why = capture.text.empty() ? entered.error().text : capture.text;
  return fail(ErrorCode::kIo, fmt::format("ROS domain {}: {}", options.reach.domain, why));
}

Result<void> Node::enter() {
  const auto inside = next_inside();
  auto domain = made(dds_create_domain(inside, domain_xml(options_.reach).c_str()), "domain");
  if (!domain) return fail(domain.error());
  domain_ = std::move(*domain);
  auto qos = tuples::dds::make_qos();
  // rmw takes only participants with an enclave for ROS; `rubicon` tells bridges from robots.
  constexpr std::string_view kWho = "enclave=/;rubicon=1;";
  dds_qset_userdata(qos.get(), kWho.data(), kWho.size());
  auto participant = made(dds_create_participant(inside, qos.get(), nullptr), "participant");
  if (!participant) return fail(participant.error());
  participant_ = std::move(*participant);
  publisher_ = Entity(dds_create_publisher(participant_.get(), nullptr, nullptr));
  subscriber_ = Entity(dds_create_subscriber(participant_.get(), nullptr, nullptr));
  graph_ = Graph(guid_of(participant_.get()), [this] {
    tell_.request();
    callbacks_.endpoints_changed();
  });
  return {};
}

/// Participants first: an endpoint belongs to one.
Result<void> Node::look() {
  const std::pair<Entity*, dds_entity_t> all[] = {{&participants_, DDS_BUILTIN_TOPIC_DCPSPARTICIPANT},
                                                  {&publications_, DDS_BUILTIN_TOPIC_DCPSPUBLICATION},
                                                  {&subscriptions_, DDS_BUILTIN_TOPIC_DCPSSUBSCRIPTION}};
  for (const auto& [reader, topic] : all) {
    auto opened = made(dds_create_reader(participant_.get(), topic, nullptr, news_.listener()), "built-in reader");
    if (!opened) return fail(opened.error());
    *reader = std::move(*opened);
  }
  return {};
}

void Node::news_of(dds_entity_t entity) {
  const bool is_graph =
      entity == participants_.get() || entity == publications_.get() || entity == subscriptions_.get();
  if (!is_graph) return callbacks_.news(entity);
  graph_.take_participants(participants_.get());
  graph_.take_publications(publications_.get());
  graph_.take_subscriptions(subscriptions_.get());
}

Result<Endpoint> Node::make(const std::string& topic, const dds_topic_descriptor_t& descriptor, const dds_qos_t* qos,
                            bool is_writer) {
  Endpoint endpoint;
  auto opened = made(dds_create_topic(participant_.get(), &descriptor, topic.c_str(), nullptr, nullptr), topic);
  if (!opened) return fail(opened.error());
  endpoint.topic = std::move(*opened);
  const auto of = endpoint.topic.get();
  auto end = made(is_writer ? dds_create_writer(publisher_.get(), of, qos, news_.listener())
                            : dds_create_reader(subscriber_.get(), of, qos, news_.listener()),
                  topic);
  if (!end) return fail(end.error());
  endpoint.end = std::move(*end);
  return endpoint;
}

Result<Endpoint> Node::writer(const std::string& name, Form form, Keep keep) {
  return make(dds_topic(name), descriptor_of(form), qos_of(keep).get(), true);
}

Result<Endpoint> Node::reader(const std::string& name, Form form, Keep keep) {
  return make(dds_topic(name), descriptor_of(form), qos_of(keep).get(), false);
}

Result<Endpoint> Node::reader_for(const Publication& publication, Form form) {
  const auto qos = qos_of(publication.reliable, publication.kept, 1);
  dds_qset_ignorelocal(qos.get(), DDS_IGNORELOCAL_PARTICIPANT);  // an import is no demand for a point of ours
  return make(dds_topic(publication.topic), descriptor_of(form), qos.get(), false);
}

bool Node::is_displaced() const {
  return addresses_ != addresses_of(options_.reach);
}

/// The name of the type is the same in both sizes, so there is one of them at a time.
void Node::say_who_we_are() {
  const auto gids = gids_for(options_.distribution, graph_.sees_hashes(), graph_.sees_none());
  const bool is_other = std::exchange(gids_, gids) != gids;
  if (is_other) info_.reset();
  if (is_other && gids != Gids::kNone) {
    if (auto made_info = make("ros_discovery_info", discovery_info_descriptor(gids), qos_of(Keep::kState).get(), true))
      info_ = std::move(*made_info);
  }
  const bool is_told = std::exchange(told_, graph_.our_changes()) == graph_.our_changes() && !is_other;
  if (info_ && !is_told) write_discovery_info(info_.get(), gids_, guid_of(participant_.get()), name_, graph_);
}

std::size_t matched_readers(dds_entity_t writer) {
  const auto count = dds_get_matched_subscriptions(writer, nullptr, 0);
  return count > 0 ? static_cast<std::size_t>(count) : 0;
}

}  // namespace rubicon::bridges::ros2
