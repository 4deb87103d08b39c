#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdio>
#include <optional>

#include "apps/rubicon/trust/commands.h"
#include "apps/rubicon/trust/phrase.h"
#include "model/json_members.h"
#include "trust/trust_folder.h"

namespace rubicon::cli::trust {

namespace {

using rubicon::trust::Issued;
using rubicon::trust::MemberOptions;

struct AddOptions {
  MemberOptions member;
  std::uint32_t island = 0;
  std::string out;
  bool here = false, people = false;
  PhraseOptions phrase;
  std::string request;  ///< file to sign

  MemberOptions wanted() const {
    auto options = member;
    if (island != 0) options.island = OwnerId(island);
    return options;
  }
};

void add_options_of_member(CLI::App* app, AddOptions& options) {
  app->add_option("--island", options.island, "for an island: its id")
      ->type_name("ID")
      ->check(CLI::Range(1U, static_cast<unsigned>(model::kMaxIslandId)).description(""));
  app->add_option("--role", options.member.roles, "role that rights name, such as admin (may be repeated)")
      ->allow_extra_args(false);
  app->add_option("--days", options.member.days, "life of the certificate")
      ->type_name("N")
      ->check(CLI::Range(1, rubicon::trust::kMaxMemberDays).description(""))
      ->capture_default_str();
}

Line issued_json(const Issued& issued, const std::string& file) {
  Line line{{"member", as_json(issued.member)}, {"realm", as_json(issued.realm)}};
  if (!file.empty()) line["file"] = file;
  return line;
}

void put_issued(Output& out, const Issued& issued, const std::string& file) {
  put(out, issued.realm);
  out.line(fmt::format("member       {}, ids {}", issued.member.name, ids_text(issued.member)));
  out.line(fmt::format("file         {}", file));
}

std::string file_of(const AddOptions& options) {
  return options.out.empty() ? options.member.name + ".trust" : options.out;
}

/// Where bundle and phrase go. Opened before there is a key: what is certified can be handed out. A bundle without a
/// key needs no phrase.
struct Outputs {
  NewFile bundle;
  std::optional<NewFile> phrase;  ///< none: the terminal
};

Result<Outputs> open_outputs(const Settings& settings, const AddOptions& options, bool has_key) {
  const auto phrase_file = has_key ? options.phrase.file : std::string();
  if (has_key && phrase_file.empty()) {
    if (const auto may = may_show_phrase(settings.json); !may) return fail(may.error());
  }
  auto bundle = NewFile::open(file_of(options));
  if (!bundle) return fail(bundle.error());
  if (phrase_file.empty()) return Outputs{std::move(*bundle), {}};
  if (std::error_code error; std::filesystem::equivalent(phrase_file, bundle->path(), error))
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: bundle and phrase in one file protect nothing, expected two files", phrase_file));
  auto phrase = NewFile::open(phrase_file);
  if (!phrase) return fail(phrase.error());
  return Outputs{std::move(*bundle), std::move(*phrase)};
}

void put_issued(const Settings& settings, Output& out, const Issued& issued, const std::string& file) {
  if (settings.json)
    out.line(model::dump(issued_json(issued, file)));
  else
    put_issued(out, issued, file);
  out.flush();
}

/// Prints what was issued, the bundle in its file; the phrase only where it is asked for.
int hand_out(const Settings& settings, const Issued& issued, Outputs& outputs) {
  if (const auto written = outputs.bundle.write(issued.bundle); !written) return failed(written.error());
  if (!issued.phrase.empty() && outputs.phrase) {
    auto written = outputs.phrase->write(issued.phrase.view());
    if (written) written = outputs.phrase->write("\n");
    if (!written) return failed(written.error());
  }
  Output out(1);
  put_issued(settings, out, issued, outputs.bundle.path());
  if (!issued.phrase.empty() && !outputs.phrase) show_phrase(issued.phrase.view());
  if (!settings.json) out.line(fmt::format("on the other host: rubicon trust dds join {}", outputs.bundle.path()));
  return ended(out, kGood);
}

int add_here(const Settings& settings, const AddOptions& options) {
  const auto folder = folder_of(settings);
  const auto readers = key_readers(options.people);
  if (!readers) return failed(readers.error());
  put_unreadable(folder);
  const auto added = rubicon::trust::add_here(folder, options.wanted(), now(), *readers);
  if (!added) return failed_at(folder, added.error());
  Output out(1);
  out.line(settings.json ? model::dump({{"member", as_json(*added)}})
                         : fmt::format("member       {}, ids {}, its key is in {}", added->name, ids_text(*added),
                                       folder.string()));
  return ended(out, kGood);
}

int add(const Settings& settings, const AddOptions& options) {
  if (options.here) return add_here(settings, options);
  if (const auto good = rubicon::trust::check_member_name(options.member.name); !good) return failed(good.error());
  auto outputs = open_outputs(settings, options, true);
  if (!outputs) return failed(outputs.error());
  const auto folder = folder_of(settings);
  put_unreadable(folder);
  const auto issued = rubicon::trust::add(folder, options.wanted(), now());
  if (!issued) return failed_at(folder, issued.error());
  return hand_out(settings, *issued, *outputs);
}

int give_out(const Settings& settings, const AddOptions& options) {
  const auto& name = options.member.name;
  if (const auto good = rubicon::trust::check_member_name(name); !good) return failed(good.error());
  const auto folder = folder_to_show(settings);
  const bool has_key = rubicon::trust::FolderFiles(folder).exists(rubicon::trust::key_file(name));
  auto outputs = open_outputs(settings, options, has_key);
  if (!outputs) return failed(outputs.error());
  const auto issued = rubicon::trust::export_member(folder, name, now());
  if (!issued) return failed_at(folder, issued.error());
  return hand_out(settings, *issued, *outputs);
}

/// A member that was certified by its request.
struct Signed {
  Issued issued;
  std::string key;  ///< its fingerprint, which `request` showed too
};

Result<Signed> signed_by(const std::filesystem::path& folder, const AddOptions& options) {
  const auto request = read_text(options.request);
  if (!request) return fail(request.error());
  auto key = rubicon::trust::key_fingerprint(*request);
  if (!key) return fail(key.error());
  auto issued = rubicon::trust::sign(folder, *request, options.wanted(), now());
  if (!issued) return fail(issued.error());
  return Signed{std::move(*issued), std::move(*key)};
}

std::string signed_text(const Signed& made) {
  const auto& member = made.issued.member;
  return fmt::format("member       {}, roles {}, ids {}\nkey fingerprint {}\n", member.name,
                     member.roles.empty() ? "none" : fmt::format("{}", fmt::join(member.roles, " ")), ids_text(member),
                     made.key);
}

void put_signed(const Settings& settings, Output& out, const Signed& made, const std::string& file) {
  if (settings.json) {
    auto line = issued_json(made.issued, file);
    line["key-fingerprint"] = made.key;
    return out.line(model::dump(line));
  }
  put(out, made.issued.realm);
  out.write(signed_text(made));
  out.line("file         " + file);
}

int sign(const Settings& settings, const AddOptions& options) {
  const auto folder = folder_of(settings);
  std::optional<NewFile> bundle;
  if (!options.out.empty()) {
    auto opened = NewFile::open(options.out);
    if (!opened) return failed(opened.error());
    bundle.emplace(std::move(*opened));
  }
  const auto made = signed_by(folder, options);
  if (!made) return failed_at(folder, made.error());
  Output out(1);
  if (!bundle) {
    out.write(made->issued.bundle);
    fmt::print(stderr, "{}", signed_text(*made));
    return ended(out, kGood);
  }
  if (const auto written = bundle->write(made->issued.bundle); !written) return failed(written.error());
  put_signed(settings, out, *made, options.out);
  return ended(out, kGood);
}

void add_phrase_option(CLI::App* app, AddOptions& options) {
  app->add_option("--phrase-file", options.phrase.file, "new file for the pass phrase, instead of the terminal")
      ->type_name("FILE");
}

void add_add(Cli& cli, CLI::App* parent) {
  const auto [app, options] = cli.command_with<AddOptions>(
      {"add", "Make a member for another host: a file to carry there, and its pass phrase",
       "  sudo rubicon trust dds add desk\n"
       "  sudo rubicon trust dds add panel --role admin --days 90\n"
       "  sudo rubicon trust dds add lab --island 7\n"
       "The phrase is shown once. --here keeps the key on this host, for a further island or service.\n",
       parent},
      add);
  app->add_option("NAME", options->member.name, "name of the member, as rights name it; never given again")->required();
  add_options_of_member(app, *options);
  app->add_option("--out", options->out, "file to write; default NAME.trust")->type_name("FILE");
  auto* here = app->add_flag("--here", options->here, "for this host: its key stays in the folder, for root only");
  app->add_flag("--people", options->people, "with --here: the people of this host (group rubicon) may use its key")
      ->needs(here);
  add_phrase_option(app, *options);
}

void add_export(Cli& cli, CLI::App* parent) {
  const auto [app, options] =
      cli.command_with<AddOptions>({"export", "Write the file of a member again, its key under a new pass phrase",
                                    "  sudo rubicon trust dds export desk\n", parent},
                                   give_out);
  app->add_option("NAME", options->member.name, "name of the member")->required();
  app->add_option("--out", options->out, "file to write; default NAME.trust")->type_name("FILE");
  add_phrase_option(app, *options);
}

void add_sign(Cli& cli, CLI::App* parent) {
  const auto [app, options] =
      cli.command_with<AddOptions>({"sign", "Answer the request of a member: a file without a key, for `join`",
                                    "  sudo rubicon trust dds sign robot.csr > robot.trust\n"
                                    "It shows name and key fingerprint; who is signed, is a member. Compare both with\n"
                                    "what `request` showed on the other host before you hand out the file.\n",
                                    parent},
                                   sign);
  app->add_option("FILE", options->request, "what `request` wrote; - = standard input")->required();
  add_options_of_member(app, *options);
  app->add_option("--out", options->out, "file to write instead of standard output")->type_name("FILE");
}

}  // namespace

void add_members(Cli& cli, CLI::App* parent) {
  add_add(cli, parent);
  add_sign(cli, parent);
  add_export(cli, parent);
}

}  // namespace rubicon::cli::trust
