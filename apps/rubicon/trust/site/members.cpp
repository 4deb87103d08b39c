#include <fmt/format.h>

#include <fstream>
#include <optional>

#include "apps/rubicon/trust/commands.h"
#include "apps/rubicon/trust/site/commands.h"
#include "base/text.h"
#include "model/json_members.h"
#include "trust/site/site_identity.h"

namespace rubicon::cli::trust::site {

namespace {

namespace sites = rubicon::trust::site;

struct NewMember {
  sites::SiteMemberOptions member;
  std::vector<std::uint32_t> islands;
  std::string folder, out, reload;
  bool here = false, people = false, password = false;
  PhraseOptions phrase;

  sites::SiteMemberOptions wanted() const {
    auto options = member;
    for (const auto id : islands) options.islands.push_back(OwnerId(id));
    return options;
  }
};

/// Where bundle and phrase go. Opened before there is a key: what is certified can be handed out.
struct Handout {
  NewFile bundle;
  std::optional<NewFile> phrase;  ///< none: the terminal
};

Result<Handout> open_handout(const Settings& settings, const std::string& bundle_file, const std::string& phrase_file) {
  if (phrase_file.empty()) {
    if (const auto may = may_show_phrase(settings.json); !may) return fail(may.error());
  }
  auto bundle = NewFile::open(bundle_file);
  if (!bundle) return fail(bundle.error());
  if (phrase_file.empty()) return Handout{std::move(*bundle), {}};
  if (std::error_code error; std::filesystem::equivalent(phrase_file, bundle->path(), error))
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: bundle and phrase in one file protect nothing, expected two files", phrase_file));
  auto phrase = NewFile::open(phrase_file);
  if (!phrase) return fail(phrase.error());
  return Handout{std::move(*bundle), std::move(*phrase)};
}

void put_member(const Settings& settings, Output& out, const sites::SiteIssued& issued, const std::string& file) {
  if (settings.json) {
    out.line(
        model::dump({{"member", as_json(issued.member)}, {"realm", trust::as_json(issued.realm)}, {"file", file}}));
  } else {
    put(out, issued.realm);
    out.line("member       " + member_text(issued.member));
    out.line("file         " + file);
  }
  out.flush();
}

/// Prints what was issued, the bundle in its file; the phrase only where it is asked for.
Result<void> hand_out_site(const Settings& settings, Output& out, const sites::SiteIssued& issued, Handout& to) {
  if (auto written = to.bundle.write(issued.bundle); !written) return written;
  if (to.phrase) {
    auto written = to.phrase->write(issued.phrase.view());
    if (written) written = to.phrase->write("\n");
    if (!written) return written;
  }
  put_member(settings, out, issued, to.bundle.path());
  if (!to.phrase) show_phrase(issued.phrase.view());
  if (!settings.json) out.line(fmt::format("on the other host: rubicon trust join {}", to.bundle.path()));
  return {};
}

int add_member_here(const Settings& settings, const NewMember& options, const std::filesystem::path& folder) {
  const auto readers = key_readers(options.people);
  if (!readers) return failed(readers.error());
  const auto added = sites::add_here(folder, options.wanted(), now(), *readers);
  if (!added) return failed_at(folder, added.error());
  Output out(1);
  out.line(settings.json ? model::dump({{"member", as_json(*added)}})
                         : fmt::format("member       {}, its key is in {}", member_text(*added), folder.string()));
  return ended(out, kGood);
}

int add_member_with_password(const Settings& settings, const NewMember& options, const std::filesystem::path& folder,
                             Handout& to) {
  const auto added = sites::add_with_password(folder, options.wanted(), now());
  if (!added) return failed_at(folder, added.error());
  Output out(1);
  if (const auto given = hand_out_site(settings, out, added->issued, to); !given) return failed(given.error());
  const auto takes = [](const auto& one) { return one.broker.setup.takes_passwords; };
  if (std::none_of(added->brokers.begin(), added->brokers.end(), takes))
    print_error("no broker of this host takes passwords: `rubicon trust broker mosquitto --passwords`");
  return put_updates(settings, out, added->brokers, options.reload);
}

int add_member(const Settings& settings, const NewMember& options) {
  const auto folder = realm_folder(options.folder);
  if (!folder) return failed(folder.error());
  if (const auto good = sites::check_user_name(options.member.name); !good) return failed(good.error());
  if (options.here) return add_member_here(settings, options, *folder);
  const auto file = options.out.empty() ? options.member.name + ".trust" : options.out;
  auto to = open_handout(settings, file, options.phrase.file);
  if (!to) return failed(to.error());
  if (options.password) return add_member_with_password(settings, options, *folder, *to);
  const auto issued = sites::add(*folder, options.wanted(), now());
  if (!issued) return failed_at(*folder, issued.error());
  Output out(1);
  if (const auto given = hand_out_site(settings, out, *issued, *to); !given) return failed(given.error());
  return ended(out, kGood);
}

struct RenewedMember {
  std::string name, folder, out, reload;
  int days = rubicon::trust::site::kMemberDays;
  bool new_key = false;
  PhraseOptions phrase;
};

std::string renewed_file(const RenewedMember& options) {
  return options.out.empty() ? options.name + ".trust" : options.out;
}

int renew_with_new_key(const Settings& settings, const RenewedMember& options, const std::filesystem::path& folder) {
  auto to = open_handout(settings, renewed_file(options), options.phrase.file);
  if (!to) return failed(to.error());
  const auto renewed = sites::renew(folder, options.name, options.days, sites::RenewKey::kMake, now());
  if (!renewed) return failed_at(folder, renewed.error());
  Output out(1);
  if (const auto given = hand_out_site(settings, out, renewed->issued, *to); !given) return failed(given.error());
  return put_updates(settings, out, renewed->brokers, options.reload);
}

/// That of this host in its place, another one by a file without a key.
int renew_member(const Settings& settings, const RenewedMember& options) {
  const auto folder = realm_folder(options.folder);
  if (!folder) return failed(folder.error());
  if (const auto good = sites::check_user_name(options.name); !good) return failed(good.error());
  if (options.new_key) return renew_with_new_key(settings, options, *folder);
  std::optional<NewFile> file;
  const bool here = rubicon::trust::FolderFiles(*folder).exists(sites::member_key(options.name));
  if (!here) {
    auto opened = NewFile::open(renewed_file(options));
    if (!opened) return failed(opened.error());
    file.emplace(std::move(*opened));
  }
  const auto renewed = sites::renew(*folder, options.name, options.days, sites::RenewKey::kKeep, now());
  if (!renewed) return failed_at(*folder, renewed.error());
  Output out(1);
  const auto& member = renewed->issued.member;
  if (file) {
    if (const auto written = file->write(renewed->issued.bundle); !written) return failed(written.error());
  }
  if (settings.json) {
    Line line{{"member", as_json(member)}};
    if (file) line["file"] = file->path();
    out.line(model::dump(line));
  } else {
    out.line("member       " + member_text(member));
    out.line(file ? fmt::format("on its host: rubicon trust join {}", file->path())
                  : "renewed; islands of this host: systemctl restart 'rubicon-proxy@*'");
  }
  return ended(out, kGood);
}

void add_days_option(CLI::App* app, int& days) {
  app->add_option("--days", days, "life of the certificate")
      ->type_name("N")
      ->check(CLI::Range(1, rubicon::trust::site::kMaxMemberDays).description(""))
      ->capture_default_str();
}

void add_bundle_options(CLI::App* app, std::string& out, PhraseOptions& phrase) {
  app->add_option("--out", out, "file to write; default NAME.trust")->type_name("FILE");
  app->add_option("--phrase-file", phrase.file, "new file for the pass phrase, instead of the terminal")
      ->type_name("FILE");
}

void add_renew(Cli& cli, CLI::App* parent) {
  const auto [app, options] = cli.command_with<RenewedMember>(
      {"renew", "Give a member a new certificate before its own ends; it keeps name, roles and islands",
       "  sudo rubicon trust renew hall              # writes hall.trust without a key, for `join` there\n"
       "  sudo rubicon trust renew hall --new-key    # its key is lost; the old certificates count no more\n",
       parent},
      renew_member);
  app->add_option("NAME", options->name, "name of the member")->required();
  app->add_flag("--new-key", options->new_key, "with a new key, in the file with a pass phrase");
  add_days_option(app, options->days);
  add_bundle_options(app, options->out, options->phrase);
  add_reload_option(app, options->reload);
  add_realm_option(app, options->folder);
}

}  // namespace

void add_members(Cli& cli, CLI::App* parent) {
  const auto [app, options] = cli.command_with<NewMember>(
      {"add", "Make a member of the realm: a file to carry to its host, and its pass phrase",
       "  sudo rubicon trust add hall --island 6541\n"
       "  sudo rubicon trust add desk --role admin\n"
       "  sudo rubicon trust add panel --password    # its phrase is its MQTT password\n"
       "The name is the MQTT user, and what rights name. The phrase is shown once.\n",
       parent},
      add_member);
  app->add_option("NAME", options->member.name, "name of the member; never given again")->required();
  app->add_option("--island", options->islands, "the member is this island (may be repeated)")
      ->type_name("ID")
      ->allow_extra_args(false)
      ->check(CLI::Range(1U, static_cast<unsigned>(model::kMaxIslandId)).description(""));
  app->add_option("--role", options->member.roles, "role that rights name, such as admin (may be repeated)")
      ->allow_extra_args(false);
  auto* password = app->add_flag("--password", options->password, "with a password instead of a certificate");
  auto* here = app->add_flag("--here", options->here, "for this host: its key stays in the folder, for the service");
  app->add_flag("--people", options->people, "with --here: the people of this host (group rubicon) may use its key")
      ->needs(here);
  password->excludes(here);
  add_days_option(app, options->member.days);
  add_bundle_options(app, options->out, options->phrase);
  add_reload_option(app, options->reload);
  add_realm_option(app, options->folder);
  add_renew(cli, parent);
}

namespace {

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

/// If the fingerprint is the one on the host with the authority, the file was not changed on its way.
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
  app->add_flag("--people", options->people, "let the people of this host (group rubicon) use its key; only as root");
  app->add_option("--phrase-file", options->phrase.file, "file with the pass phrase")->type_name("FILE");
  add_realm_option(app, options->folder);
}

}  // namespace rubicon::cli::trust::site
