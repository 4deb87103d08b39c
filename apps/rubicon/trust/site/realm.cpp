#include <fmt/format.h>
#include <fmt/ranges.h>

#include "apps/rubicon/trust/site/commands.h"
#include "model/json_members.h"

namespace rubicon::cli::trust::site {

namespace {

namespace sites = rubicon::trust::site;

/// Soon enough to renew in peace.
constexpr int kSoonDays = 30;

struct RealmInit {
  sites::SiteInit init;
  std::string folder, former;
};

int init_realm(const Settings& settings, const RealmInit& asked) {
  if (!asked.former.empty())
    return failed({ErrorCode::kInvalid,
                   "--for made certificates for DDS, which this release does not have: rubicon-trust@.service of an "
                   "earlier release runs it, remove that unit (docs/trust.md)"});
  const auto folder = realm_folder(asked.folder);
  if (!folder) return failed(folder.error());
  const auto made = sites::init(*folder, asked.init, now());
  if (!made) return failed_at(*folder, made.error());
  Output out(1);
  if (settings.json) {
    out.line(model::dump({{"realm", trust::as_json(*made)}, {"folder", folder->string()}}));
    return ended(out, kGood);
  }
  put(out, *made);
  out.line(fmt::format("{}: a new realm of brokers; keep a copy of this folder after each change", folder->string()));
  out.line(fmt::format("next: `rubicon trust broker mosquitto{}` for the broker, `rubicon trust add NAME` for members",
                       asked.init.brokers.empty() ? " --broker HOST" : ""));
  return ended(out, kGood);
}

std::string state_of_member(const ListedSiteMember& one) {
  if (!one.ends) return "good";
  const auto days = std::chrono::floor<std::chrono::days>(*one.ends - now()).count();
  if (days < 0) return "expired";
  return days < kSoonDays ? fmt::format("{} days left", days) : "good";
}

std::string table_of_members(const Output& out, const sites::SiteContents& there) {
  Table table({{"member"}, {"roles"}, {"islands"}, {"until"}, {"key"}, {"state"}});
  for (const auto& one : there.members) {
    std::vector<std::uint32_t> islands;
    for (const auto id : one.islands) islands.push_back(number(id));
    const auto until = one.has_password ? "password" : one.ends ? time_text(*one.ends).substr(0, 10) : "";
    table.row({one.name, fmt::format("{}", fmt::join(one.roles, ", ")), fmt::format("{}", fmt::join(islands, ", ")),
               until, one.has_key ? "here" : "elsewhere", state_of_member(one)});
  }
  for (const auto& name : there.revoked) table.row({name, "", "", "", "", "revoked"});
  return table.text({out.has_colour(), out.width()});
}

Line json_of_realm(const sites::SiteContents& there, const std::filesystem::path& folder) {
  Line line{{"realm", trust::as_json(there.realm)},
            {"folder", folder.string()},
            {"number", there.number},
            {"authority", there.has_authority},
            {"authority-days-left", there.authority_days_left},
            {"members", Line::array()},
            {"revoked", there.revoked},
            {"hosts", there.hosts},
            {"brokers", Line::array()}};
  for (const auto& one : there.members) {
    auto member = as_json(one);
    member["has-key"] = one.has_key;
    line["members"].push_back(std::move(member));
  }
  for (const auto& one : there.brokers)
    line["brokers"].push_back({{"folder", one.setup.folder},
                               {"port", one.setup.port},
                               {"passwords", one.setup.takes_passwords},
                               {"unit", one.unit}});
  return line;
}

int show_realm(const Settings& settings, const std::string& named) {
  if (const auto meant = realm_folder(named); !meant) return failed(meant.error());
  const auto folder = folder_to_show(named);
  const auto there = sites::contents_of(folder, now());
  if (!there) return failed_at(folder, there.error());
  Output out(1);
  if (settings.json) {
    out.line(model::dump(json_of_realm(*there, folder)));
    return ended(out, kGood);
  }
  put(out, there->realm);
  out.line(fmt::format("folder       {}{}", folder.string(),
                       there->has_authority ? ", with the authority: members are added here" : ""));
  for (const auto& one : there->brokers)
    out.line(fmt::format("broker       {}, port {}{}", one.setup.folder, one.setup.port,
                         one.setup.takes_passwords ? fmt::format(", with passwords {}", one.setup.port + 1) : ""));
  out.write(table_of_members(out, *there));
  return ended(out, kGood);
}

}  // namespace

void add_init(Cli& cli, CLI::App* parent) {
  const auto [app, options] = cli.command_with<RealmInit>(
      {"init", "Make a realm of MQTT brokers: the authority that certifies brokers and members",
       "  sudo rubicon trust init --broker broker.example.org\n"
       "  sudo rubicon trust init --name Hall\n",
       parent},
      init_realm);
  app->add_option("--name", options->init.realm, "name of the realm; a random end is added")->capture_default_str();
  app->add_option("--broker", options->init.brokers,
                  "how members reach the broker, HOST or HOST:PORT (may be repeated)")
      ->allow_extra_args(false);
  add_realm_option(app, options->folder);
  app->add_option("--for", options->former, "of an earlier release")->group("");
}

void add_show(Cli& cli, CLI::App* parent) {
  const auto [app, folder] = cli.command_with<std::string>(
      {"show", "Show the realm of a folder, its fingerprint, members, islands and brokers",
       "  rubicon trust show\n"
       "  rubicon trust show --json\n",
       parent},
      show_realm);
  app->alias("list");
  add_realm_option(app, *folder);
}

}  // namespace rubicon::cli::trust::site
