#include <fmt/format.h>

#include <fstream>

#include "apps/rubicon/trust/phrase.h"
#include "apps/rubicon/trust/site/commands.h"
#include "base/host_port.h"
#include "model/json_members.h"
#include "trust/site/site_place.h"

namespace rubicon::cli::trust::site {

namespace {

namespace sites = rubicon::trust::site;

constexpr std::uint16_t kBrokerPort = 8883;

struct JoinedMember {
  std::string file, folder;
  bool yes = false, older = false, people = false;
  PhraseOptions phrase;
};

/// `mqtt` of the configuration: the first broker, and the others while that is away.
std::string broker_config(const sites::SiteBundleContents& bundle, const std::filesystem::path& folder) {
  const sites::SitePlace place{folder, bundle.member.name};
  const auto address =
      bundle.brokers.empty() ? std::nullopt : base::parse_host_port(bundle.brokers.front(), kBrokerPort);
  auto text =
      fmt::format("host: {}, port: {}", address ? address->host : "HOST", address ? address->port : kBrokerPort);
  text += bundle.member.has_password ? fmt::format(", tls: {{ca: {}}}, user: {}, password-file: {}", place.authority(),
                                                   place.user, place.password())
                                     : fmt::format(", tls: {{ca: {}, certificate: {}, key: {}}}", place.authority(),
                                                   place.certificate(), place.key());
  if (bundle.brokers.size() < 2) return fmt::format("{{broker: {{{}}}}}", text);
  const std::vector<std::string> spare(bundle.brokers.begin() + 1, bundle.brokers.end());
  return fmt::format("{{broker: {{{}}}, spare_brokers: [{}]}}", text, fmt::join(spare, ", "));
}

/// A person who has no other file for tools gets one. Its path; empty = none was written.
std::string write_ecology_file(const std::filesystem::path& folder, const std::string& broker) {
  const auto file = folder.parent_path() / "ecology.yaml";
  std::error_code none;
  if (folder != sites::own_site_folder() || std::filesystem::exists(file, none)) return {};
  std::ofstream out(file);
  out << "# What the tools of this user join. Written by `rubicon trust join`; it is yours now.\ntuples:\n  mqtt: "
      << broker << "\n";
  return out.flush() ? file.string() : std::string();
}

void put_bundle(Output& out, const sites::SiteBundleContents& bundle) {
  put(out, bundle.realm);
  out.line("member       " + member_text(bundle.member));
}

void put_joined(const Settings& settings, Output& out, const sites::SiteBundleContents& joined,
                const std::filesystem::path& folder, const std::string& file) {
  const auto broker = broker_config(joined, folder), written = write_ecology_file(folder, broker);
  if (settings.json) {
    out.line(model::dump({{"realm", trust::as_json(joined.realm)},
                          {"member", as_json(joined.member)},
                          {"brokers", joined.brokers},
                          {"folder", folder.string()},
                          {"mqtt", broker},
                          {"tools", written}}));
    return;
  }
  out.line(fmt::format("joined       {}; the file {} is needed no more: remove it", folder.string(), file));
  if (!written.empty())
    return out.line("tools        " + written + ": `rubicon islands` shows the islands of all sites");
  out.line("for the configuration of the island, or of a tool (--config):");
  out.line("  tuples:");
  out.line("    mqtt: " + broker);
}

/// Nobody has changed the file on its way if the fingerprint is that of the host with the authority.
Result<bool> is_fingerprint_right(const JoinedMember& options) {
  if (options.yes) return true;
  return confirmed("Is that the fingerprint which `rubicon trust show` prints on the host that made the file?");
}

int join_realm(const Settings& settings, const JoinedMember& options) {
  const auto folder = joined_folder(options.folder);
  if (!folder) return failed(folder.error());
  const auto text = read_text(options.file);
  if (!text) return failed(text.error());
  const auto bundle = sites::inspect_bundle(*text, now());
  if (!bundle) return failed({bundle.error().code, fmt::format("{}: {}", options.file, bundle.error().text)});
  const auto readers = key_readers(options.people);
  if (!readers) return failed(readers.error());
  Output out(1);
  if (!settings.json) put_bundle(out, *bundle);
  out.flush();
  const auto right = is_fingerprint_right(options);
  if (!right) return failed(right.error());
  if (!*right) return failed({ErrorCode::kRefused, "not joined: the fingerprint was not confirmed"});
  SecretText phrase;
  if (bundle->needs_phrase) {
    auto typed = read_phrase(options.phrase, "phrase: ");
    if (!typed) return failed(typed.error());
    phrase = std::move(*typed);
  }
  const auto whole = std::filesystem::absolute(*folder).lexically_normal();
  const auto joined = sites::join_site(
      whole, *text, phrase.view(), now(),
      options.older ? rubicon::trust::site::Older::kTake : rubicon::trust::site::Older::kRefuse, *readers);
  if (!joined) return failed_at(*folder, joined.error());
  put_joined(settings, out, *joined, whole, options.file);
  return ended(out, kGood);
}

}  // namespace

void add_join(Cli& cli, CLI::App* parent) {
  const auto [app, options] = cli.command_with<JoinedMember>(
      {"join", "Take part in the realm of another host, by the file that it made for this one",
       "  sudo rubicon trust join hall.trust         # for an island: into /etc/rubicon/realm\n"
       "  rubicon trust join desk.trust              # for a person: into ~/.config/rubicon/realm\n"
       "  rubicon trust join desk.trust --yes < phrase\n"
       "Asks for the pass phrase, which is not shown, and whether the fingerprint is right. Then it\n"
       "shows the lines of the configuration.\n",
       parent},
      join_realm);
  app->add_option("FILE", options->file, "what `add` or `renew` wrote")->required();
  app->add_flag("--yes", options->yes, "the fingerprint was compared before");
  app->add_flag("--older", options->older, "take the file even if the certificate that is there ends later");
  app->add_flag("--people", options->people, "as root: the people of this host (group rubicon) may use its key");
  app->add_option("--phrase-file", options->phrase.file, "file with the pass phrase")->type_name("FILE");
  add_realm_option(app, options->folder);
}

}  // namespace rubicon::cli::trust::site
