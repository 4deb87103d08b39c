#include "apps/rubicon/broker_findings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <filesystem>

#include "apps/rubicon/table.h"
#include "client/ecology_options.h"
#include "transport/poll_loop.h"
#include "trust/site/site_folder.h"

namespace rubicon::cli {

namespace {

using Grade = Finding::Grade;

constexpr const char* kSites = "sites";
constexpr int kRenewSoon = 30;              ///< days
constexpr std::size_t kMaxNamesShown = 10;  ///< of users that are strange

/// A part of the reason why there is no connection, and what to do. The first that fits counts.
struct BrokerAdvice {
  std::string_view part, fix;
};
constexpr std::array kBrokerAdvice{
    BrokerAdvice{"cannot be found", "compare `host` with the name of the broker's host (getent hosts NAME)"},
    BrokerAdvice{"Connection refused",
                 "no broker listens there: start it (systemctl start rubicon-broker@main), or correct `host` and "
                 "`port`"},
    BrokerAdvice{"mismatch",
                 "the broker has a certificate for another name: correct `host`, or on its host `rubicon trust broker "
                 "mosquitto --broker NAME`"},
    BrokerAdvice{"certificate of the broker is not accepted",
                 "`tls: {ca: ...}` has to be the ca.pem of the realm that the broker is of; else the clock of one of "
                 "both hosts is wrong (timedatectl)"},
    BrokerAdvice{"does it want our certificate",
                 "the broker does not take the certificate: it has ended, or was revoked (`rubicon trust show` on the "
                 "host with the authority), or the port is that for passwords"},
    BrokerAdvice{"does it expect TLS",
                 "`tls: {ca: ..., certificate: ..., key: ...}`, as `rubicon trust join` shows the lines"},
    BrokerAdvice{"TLS failed", "the port is not one with TLS, or the certificate was refused: compare `port`"},
    BrokerAdvice{"user or the password",
                 "the broker does not know this user, or its password is another one: compare `user`, and "
                 "`password-file` with the phrase of `rubicon trust add`"},
    BrokerAdvice{"not authorised",
                 "the broker does not know this user, or its password is another one: compare `user`, and "
                 "`password-file` with the phrase of `rubicon trust add`"},
    BrokerAdvice{"the broker does not answer", "the broker hangs, or the port is that of another service"},
    BrokerAdvice{"does not answer", "the host is off, or a firewall drops what comes to that port"},
};

Finding check_connection(const BrokerSeen& broker) {
  const auto& why = broker.failure->text;
  const auto found = std::find_if(kBrokerAdvice.begin(), kBrokerAdvice.end(),
                                  [&](const auto& one) { return why.find(one.part) != why.npos; });
  return {kSites, Grade::kProblem, fmt::format("no connection with the broker: {}", why),
          found == kBrokerAdvice.end() ? "the text is that of the broker or of the system; " + page("sites.md#settings")
                                       : std::string(found->fix)};
}

Finding connected(const BrokerSeen& broker) {
  std::size_t components = 0;
  for (const auto& [user, ids] : broker.users) components += ids.size();
  return {kSites, Grade::kGood,
          fmt::format("connected with the broker {} as {}, by MQTT {}{}; space {} has {} of {}", broker.place,
                      broker.user == tuples::mqtt::kAnonymous ? "nobody" : broker.user,
                      broker.version == transport::MqttVersion::k5 ? "5" : "3.1.1", broker.tls ? " with TLS" : "",
                      broker.space, counted(components, "component"), counted(broker.users.size(), "user"))};
}

/// What its rights are worth, as far as this user can find out.
Finding check_protection(const BrokerSeen& broker) {
  if (!broker.retains)
    return {kSites, Grade::kProblem,
            fmt::format("the broker {} keeps no retained messages: components do not find each other", broker.place),
            "allow them: `retain_available true` (mosquitto)"};
  if (!broker.hands_on)
    return {kSites, Grade::kProblem,
            fmt::format("the broker {} does not hand on what {} sends to itself", broker.place, broker.user),
            "give its users the four rights that " + page("sites.md#what-the-broker-reads") + " names"};
  if (broker.forges)
    return {kSites, Grade::kNote,
            fmt::format("the broker {} lets {} write in the name of others: the names of its users prove nothing",
                        broker.place, broker.user == tuples::mqtt::kAnonymous ? "whoever connects" : broker.user),
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
    add({{kSites, Grade::kProblem, fmt::format("{} is no member of the realm {}", broker.user, realm.name),
          "`rubicon trust add` on the host with the authority, `rubicon trust join` here"}});
  }
  if (seen.on_disk < realm.number)
    add({{kSites, Grade::kNote,
          fmt::format("the realm file in {} has number {}, that of {} has {}", seen.folder, seen.on_disk, seen.shown_by,
                      realm.number),
          "nothing: programs take the newer one while they run. A program that may write the folder keeps it there"}});
  for (const auto& key : seen.open_keys)
    add({{kSites, Grade::kProblem, key + ": others may read this key, and take part in the name of its member",
          fmt::format("chmod 600 {0}; whoever read it has it: rubicon trust renew the member", key)}});
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
                            Loss{"mqtt-frames-again", "sent frames again that nobody acknowledged in time",
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

/// Those of members and of the authority below `folder` to which others of this host have access.
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
