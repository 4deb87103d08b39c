#include <fmt/format.h>

#include <cstdio>

#include "apps/rubicon/trust/commands.h"
#include "apps/rubicon/trust/phrase.h"
#include "model/json_members.h"

namespace rubicon::cli::trust {

namespace {

using rubicon::trust::BundleContents;

struct JoinOptions {
  std::string file;
  bool yes = false, older = false, people = false;
  PhraseOptions phrase;
};

void show(Output& out, const BundleContents& bundle) {
  put(out, bundle.realm);
  out.line(fmt::format("member       {}, ids {}, until {}", printable(bundle.member.name), ids_text(bundle.member),
                       time_text(bundle.member.expires).substr(0, 10)));
}

/// Nobody has changed the file on its way if the fingerprint is that of the host with the authority.
Result<bool> is_right(const JoinOptions& options) {
  if (options.yes) return true;
  return confirmed("Is that the fingerprint which `rubicon trust dds show` prints on the host that made the file?");
}

int join(const Settings& settings, const JoinOptions& options) {
  const auto text = read_text(options.file);
  if (!text) return failed(text.error());
  const auto bundle = rubicon::trust::inspect(*text, now());
  if (!bundle) return failed({bundle.error().code, fmt::format("{}: {}", options.file, bundle.error().text)});
  const auto folder = own_folder(settings);
  if (!folder) return failed(folder.error());
  const auto readers = key_readers(options.people);
  if (!readers) return failed(readers.error());
  Output out(1);
  if (!settings.json) show(out, *bundle);
  out.flush();
  const auto right = is_right(options);
  if (!right) return failed(right.error());
  if (!*right) return failed({ErrorCode::kRefused, "not joined: the fingerprint was not confirmed"});
  SecretText phrase;
  if (bundle->has_key) {
    auto typed = read_phrase(options.phrase, "phrase: ");
    if (!typed) return failed(typed.error());
    phrase = std::move(*typed);
  }
  const auto joined =
      rubicon::trust::join(*folder, *text, phrase.view(), now(),
                           options.older ? rubicon::trust::Older::kTake : rubicon::trust::Older::kRefuse, *readers);
  if (!joined) return failed_at(*folder, joined.error());
  if (settings.json) {
    out.line(model::dump(
        {{"realm", as_json(joined->realm)}, {"member", as_json(joined->member)}, {"folder", folder->string()}}));
  } else {
    out.line(fmt::format("joined       {}; the file {} is needed no more: remove it", folder->string(), options.file));
  }
  return ended(out, kGood);
}

int request(const Settings& settings, const std::string& name) {
  const auto folder = own_folder(settings);
  if (!folder) return failed(folder.error());
  const auto made = rubicon::trust::request(*folder, name);
  if (!made) return failed_at(*folder, made.error());
  const auto key = rubicon::trust::key_fingerprint(*made);
  if (!key) return failed(key.error());
  Output out(1);
  out.write(*made);
  fmt::print(stderr, "member       {}\nkey fingerprint {}\n", name, *key);
  return ended(out, kGood);
}

}  // namespace

void add_join(Cli& cli, CLI::App* parent) {
  const auto [app, options] = cli.command_with<JoinOptions>(
      {"join", "Take the certificate that another host made for this one",
       "  rubicon trust dds join desk.trust\n"
       "  sudo rubicon trust dds join lab.trust          # for an island: into /etc/rubicon/trust\n"
       "  rubicon trust dds join desk.trust --yes < phrase\n"
       "Asks for the pass phrase, which is not shown, and whether the fingerprint is right.\n",
       parent},
      join);
  app->add_option("FILE", options->file, "what `add`, `sign`, `renew` or `export` wrote")->required();
  app->add_flag("--yes", options->yes, "the fingerprint was compared before");
  app->add_flag("--older", options->older, "take the file even if the certificate that is there ends later");
  app->add_flag("--people", options->people, "as root: the people of this host (group rubicon) may use its key");
  app->add_option("--phrase-file", options->phrase.file, "file with the pass phrase")->type_name("FILE");
}

void add_request(Cli& cli, CLI::App* parent) {
  const auto [app, name] = cli.command_with<std::string>(
      {"request", "Make a key that never leaves this host, and the request for its certificate",
       "  rubicon trust dds request robot > robot.csr     # on the robot\n"
       "  sudo rubicon trust dds sign robot.csr > robot.trust\n"
       "  rubicon trust dds join robot.trust              # on the robot again\n"
       "It shows name and key fingerprint, and so does `sign`: compare both.\n",
       parent},
      request);
  app->add_option("NAME", *name, "name of the member")->required();
}

}  // namespace rubicon::cli::trust
