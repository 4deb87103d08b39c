#include "apps/rubicon/doctor/broker_findings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <random>

#include "apps/rubicon/doctor/remedies.h"
#include "apps/rubicon/output/table.h"
#include "client/ecology_options.h"
#include "transport/poll_loop.h"
#include "trust/site/site_folder.h"
#include "tuples/mqtt/messages.h"

namespace rubicon::cli {

namespace {

namespace mqtt = tuples::mqtt;

constexpr const char* kLastMessage = "fence";
/// Of users and components that are kept of one broker.
constexpr std::size_t kMaxSeen = 100'000;

class BrokerLook {
 public:
  BrokerLook(transport::PollLoop& loop, tuples::mqtt::SpaceOptions options)
      : loop_(loop), options_(std::move(options)), topics_(options_.space) {
    seen_.place = fmt::format("{}:{}", broker().host, broker().port);
    seen_.space = options_.space;
    seen_.user = options_.brokers.front().user;
    seen_.tls = broker().tls.has_value();
    own_.user = seen_.user;
    std::random_device source;
    own_.token = fmt::format("{:04x}{:08x}", source() & 0xffffU, source());
  }

  BrokerSeen look(Duration patience) {
    broker().connect_time = patience;
    auto opened = sockets_.open_mqtt(broker(), calls());
    if (!opened) {
      seen_.failure = opened.error();
      return std::move(seen_);
    }
    line_ = std::move(*opened);
    wait([this] { return connected_; }, 2 * patience);  // of both versions of MQTT
    if (connected_) wait([this] { return seen_.hands_on; }, patience);
    for (const auto& [at, id] : components_) {
      if (!lines_.contains(at)) seen_.ghosts.emplace_back(at.user, id);
    }
    return std::move(seen_);
  }

 private:
  transport::MqttOptions& broker() { return options_.brokers.front().line; }
  template <class Done>
  void wait(Done done, Duration most) {
    const auto ends = loop_.now() + most;
    for (auto now = loop_.now(); !done() && !seen_.failure && now < ends; now = loop_.now()) {
      loop_.wait(ends - now);
      loop_.poll();
    }
  }

  transport::MqttCallbacks calls() {
    transport::MqttCallbacks calls;
    calls.connected = [this](const transport::MqttConnack& connack) { on_connected(connack); };
    calls.received = [this](const transport::MqttMessage& message) { on_message(message); };
    calls.failed = [this](const Error& why) { seen_.failure = why; };
    return calls;
  }

  /// The inbox first: a forged message to it would arrive before the last one. The other forged one stands where only
  /// this program reads.
  void on_connected(const transport::MqttConnack& connack) {
    connected_ = true;
    seen_.version = connack.version;
    seen_.retains = connack.retains;
    forged_ = {topics_.inbox_probe(own_), topics_.presence_probe(own_)};
    for (const auto& filter : {topics_.inbox_filter(own_), fmt::format("rubicon-space/1/{}/p/#", options_.space)})
      std::ignore = line_->subscribe(filter, 0);
    for (const auto& topic : forged_) std::ignore = line_->publish({topic, "probe", false, 0, {}, {}, 0});
    std::ignore = line_->publish({topics_.inbox(own_, own_), kLastMessage, false, 0, {}, {}, 0});
  }

  void on_message(const transport::MqttMessage& message) {
    if (message.topic == topics_.inbox(own_, own_)) seen_.hands_on = true;
    seen_.forges |= forged_.contains(std::string(message.topic));
    if (message.payload.empty()) return;
    if (const auto user = topics_.user_of_document(message.topic)) {
      seen_.documents[*user] = message.payload;
      return;
    }
    const auto at = topics_.parse(message.topic);
    const auto* presence = std::get_if<mqtt::Topics::Presence>(&at);
    if (presence == nullptr || components_.size() + lines_.size() >= kMaxSeen) return;
    auto& ids = seen_.users[presence->line.user];
    if (!presence->component) return void(lines_.insert(presence->line));
    ids.insert(*presence->component);
    components_.emplace(presence->line, *presence->component);
  }

  transport::PollLoop& loop_;
  transport::PollSockets sockets_{loop_};
  tuples::mqtt::SpaceOptions options_;
  mqtt::Topics topics_;
  mqtt::Line own_;
  std::set<std::string> forged_;
  std::set<mqtt::Line> lines_;
  std::set<std::pair<mqtt::Line, OwnerId>> components_;
  bool connected_ = false;
  BrokerSeen seen_;
  std::unique_ptr<transport::MqttLine> line_;
};

}  // namespace

BrokerSeen look_at_broker(const client::Options& options, Duration patience) {
  BrokerSeen none;
  none.place = options.broker.host;
  auto engines = client::engine_options(options);
  auto loop = transport::PollLoop::make();
  if (!engines) none.failure = engines.error();
  if (!loop) none.failure = loop.error();
  if (none.failure) return none;
  return BrokerLook(**loop, std::move(*engines->mqtt)).look(patience);
}

namespace {

using Grade = Finding::Grade;

constexpr const char* kSites = "sites";
constexpr int kRenewSoon = 30;              ///< days
constexpr std::size_t kMaxNamesShown = 10;  ///< of users that are strange

Finding check_connection(const BrokerSeen& broker) {
  const auto* remedy = remedy_of(broker.failure->finding);
  return {kSites, Grade::kProblem, fmt::format("no connection with the broker: {}", broker.failure->text),
          !remedy ? "the text is that of the broker or of the system; " + page("sites.md#settings")
                  : std::string(remedy->for_broker.empty() ? remedy->fix : remedy->for_broker)};
}

Finding connected(const BrokerSeen& broker) {
  std::size_t components = 0;
  for (const auto& [user, ids] : broker.users) components += ids.size();
  return {kSites, Grade::kGood,
          fmt::format("connected with the broker {} {}, by MQTT {}{}; space {} has {} of {}", broker.place,
                      broker.user == tuples::mqtt::kAnonymous ? "without a user" : "as " + broker.user,
                      broker.version == transport::MqttVersion::k5 ? "5" : "3.1.1", broker.tls ? " with TLS" : "",
                      broker.space, counted(components, "component"), counted(broker.users.size(), "user"))};
}

/// Whether the rights of the broker protect others, as far as this user can find out.
Finding check_protection(const BrokerSeen& broker) {
  if (!broker.retains)
    return {kSites, Grade::kProblem,
            fmt::format("the broker {} keeps no retained messages: components do not find each other", broker.place),
            "allow them: `retain_available true` (mosquitto)"};
  if (!broker.hands_on)
    return {kSites, Grade::kProblem,
            fmt::format("the broker {} does not deliver what {} sends to itself", broker.place, broker.user),
            "give its users the four rights that " + page("sites.md#what-the-broker-reads") + " names"};
  if (broker.forges)
    return {kSites, Grade::kNote,
            fmt::format("the broker {} lets {} write in the name of others: the names of its users prove nothing",
                        broker.place, broker.user == tuples::mqtt::kAnonymous ? "any client" : broker.user),
            "give its users the four rights that " + page("sites.md#what-the-broker-reads") + " names"};
  return {kSites, Grade::kGood,
          fmt::format("the rights of the broker {} protect others from {}", broker.place, broker.user)};
}

std::string some_of(const std::vector<std::string>& names) {
  const auto shown = std::min(names.size(), kMaxNamesShown);
  return fmt::format("{}{}", fmt::join(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(shown), ", "),
                     shown < names.size() ? fmt::format(" and {} more", names.size() - shown) : "");
}

Findings check_users(const BrokerSeen& broker, const rubicon::trust::site::SiteRealm& realm) {
  std::vector<std::string> strange, revoked;
  for (const auto& [user, components] : broker.users) {
    if (realm.is_revoked(user)) {
      revoked.push_back(user);
    } else if (!realm.is_member(user)) {
      strange.push_back(user);
    }
  }
  Findings all;
  if (!revoked.empty())
    all.push_back(
        {kSites, Grade::kNote,
         fmt::format("the broker {} still has presence of who was shut out: {}", broker.place, some_of(revoked)),
         "members ignore them; so that the broker does too: systemctl reload rubicon-broker@main on its host"});
  if (!strange.empty())
    all.push_back({kSites, Grade::kProblem,
                   fmt::format("the broker {} has users that the realm {} does not have: {}", broker.place, realm.name,
                               some_of(strange)),
                   "members ignore them. Let the broker take users of this realm only; " +
                       page("sites.md#what-the-broker-reads")});
  return all;
}

Findings check_ghosts(const BrokerSeen& broker) {
  if (broker.ghosts.empty()) return {};
  std::vector<std::string> names;
  for (const auto& [user, id] : broker.ghosts) names.push_back(fmt::format("{} of {}", number(id), user));
  return {{kSites, Grade::kNote,
           fmt::format("the broker {} has {} without a connection: {}", broker.place,
                       counted(names.size(), "component"), some_of(names)),
           "programs ignore them; what a broker kept of a time before goes by itself within an hour"}};
}

Findings check_end(const std::string& of, int days, const std::string& fix) {
  if (days >= kRenewSoon) return {};
  if (days < 0) return {{kSites, Grade::kProblem, of + " has ended", fix}};
  return {
      {kSites, Grade::kNote, fmt::format("{} ends in {}", of, counted(static_cast<std::size_t>(days), "day")), fix}};
}

Findings check_realm(const BrokerSeen& broker, const RealmSeen& seen, WallTime now) {
  Findings all;
  const auto add = [&all](Findings more) { std::move(more.begin(), more.end(), std::back_inserter(all)); };
  const auto& realm = seen.realm;
  if (realm.is_revoked(broker.user)) {
    add({{kSites, Grade::kProblem, fmt::format("{} was shut out of the realm {}", broker.user, realm.name),
          "`rubicon trust add` on the host with the authority makes a member of another name"}});
  } else if (!realm.is_member(broker.user)) {
    add({{kSites, Grade::kProblem, fmt::format("{} is not a member of the realm {}", broker.user, realm.name),
          "`rubicon trust add` on the host with the authority, `rubicon trust join` here"}});
  }
  if (seen.on_disk < realm.number)
    add({{kSites, Grade::kNote,
          fmt::format("the realm file in {} has number {}, the one that {} shows has {}", seen.folder, seen.on_disk,
                      seen.shown_by, realm.number),
          "nothing: programs take the newer one while they run. A program that may write the folder stores it there"}});
  for (const auto& key : seen.open_keys)
    add({{kSites, Grade::kProblem, key + ": others may read this key and act as its member",
          fmt::format("chmod 600 {0}; it may have been copied: renew the member by rubicon trust renew", key)}});
  add(check_users(broker, realm));
  const auto days_to = [&](WallTime end) {
    return static_cast<int>(std::chrono::floor<std::chrono::days>(end - now).count());
  };
  if (seen.own_ends)
    add(check_end("the certificate of " + broker.user, days_to(*seen.own_ends),
                  fmt::format("rubicon trust renew {} on the host with the authority, then rubicon trust join here",
                              broker.user)));
  if (seen.authority_days_left)
    add(check_end("the authority of the realm " + realm.name, *seen.authority_days_left,
                  "make a new realm: rubicon trust init, and let all join it"));
  return all;
}

}  // namespace

Findings check_broker(const BrokerSeen& broker, const RealmSeen* realm, WallTime now) {
  Findings all;
  const auto add = [&all](Findings more) { std::move(more.begin(), more.end(), std::back_inserter(all)); };
  if (broker.failure) {
    add({check_connection(broker)});
  } else {
    add({connected(broker), check_protection(broker)});
    add(check_ghosts(broker));
  }
  if (realm) add(check_realm(broker, *realm, now));
  return all;
}

Findings check_broker_losses(const IslandSeen& seen) {
  struct Loss {
    const char *counter, *what, *fix;
  };
  constexpr std::array kAll{Loss{"mqtt-reconnects", "lost its broker and found it again",
                                 "look at the log of the broker, and at the network"},
                            Loss{"mqtt-gaps", "missed frames that the broker dropped, which were sent again",
                                 "`max_queued_messages 100000` at the broker, or a faster line"},
                            Loss{"mqtt-frames-again", "sent frames again that were not acknowledged in time",
                                 "`max_queued_messages 100000` at the broker, or a faster line"}};
  Findings all;
  for (const auto& one : kAll) {
    const auto count = seen.numbers.find(one.counter);
    if (count == seen.numbers.end() || count->second == 0) continue;
    const auto before = seen.numbers_before.find(one.counter);
    const auto grown =
        !seen.known_before ? 0 : count->second - (before == seen.numbers_before.end() ? 0 : before->second);
    all.push_back({kSites, grown > 0 ? Grade::kNote : Grade::kGood,
                   fmt::format("island {} {}: {} since its start, {} during the check", name_of(seen.island), one.what,
                               count->second, grown),
                   grown > 0 ? one.fix : ""});
  }
  return all;
}

namespace {

/// Key files of members and of the authority below `folder` that other users of this host can access.
std::vector<std::string> open_keys(const rubicon::trust::site::SiteFolder& folder) {
  std::vector<std::string> names{rubicon::trust::site::kAuthorityKeyFile}, found;
  for (const auto& user : folder.members()) {
    names.push_back(rubicon::trust::site::member_key(user));
    names.push_back(rubicon::trust::site::member_password(user));
  }
  for (const auto& name : names) {
    std::error_code error;
    auto path = folder.files().path(name);
    const auto mode = std::filesystem::status(path, error).permissions();
    if (!error && mode != std::filesystem::perms::unknown &&
        (mode & std::filesystem::perms::others_all) != std::filesystem::perms::none)
      found.push_back(std::move(path));
  }
  return found;
}

}  // namespace

Result<std::optional<RealmSeen>> look_at_realm(const client::Options& options, const BrokerSeen& broker) {
  base::NullLogSink quiet;
  auto loop = transport::PollLoop::make();
  if (!loop) return fail(loop.error());
  auto opened = client::open_realm(options, **loop, quiet);
  if (!opened) return fail(opened.error());
  if (!*opened) return std::optional<RealmSeen>();
  auto& live = **opened;
  RealmSeen seen;
  seen.folder = std::filesystem::path(options.broker.ca_file).parent_path().string();
  seen.on_disk = live.realm().number;
  for (const auto& [user, document] : broker.documents) {
    if (live.take(document, user) == tuples::UserRealm::Taken::kNewer) seen.shown_by = user;
  }
  seen.realm = live.realm();
  seen.open_keys = open_keys(rubicon::trust::site::SiteFolder(seen.folder));
  if (const auto contents = rubicon::trust::site::contents_of(seen.folder, (*loop)->wall_now())) {
    seen.authority_days_left = contents->authority_days_left;
    for (const auto& one : contents->members) {
      if (one.name == broker.user) seen.own_ends = one.ends;
    }
  }
  return std::optional(std::move(seen));
}

}  // namespace rubicon::cli
