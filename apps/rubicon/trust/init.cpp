#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "apps/rubicon/trust/commands.h"
#include "apps/rubicon/trust/needs_host.h"
#include "base/config_reader.h"
#include "config/config_file.h"
#include "model/json_members.h"
#include "trust/place.h"
#include "trust/started_realm.h"
#include "trust/trust_folder.h"

namespace rubicon::cli::trust {

namespace {

namespace fs = std::filesystem;
using rubicon::trust::FolderContents;
using rubicon::trust::StartedRealm;
using rubicon::trust::TrustFolder;
using rubicon::trust::whole_path;

/// A configuration of this host, or why its island gets no certificate.
struct Found {
  std::string file;
  Result<OwnerId> island;
};

Result<OwnerId> island_of(const std::string& file) {
  const auto root = config::load_config(file, {});
  if (!root) return fail(root.error());
  ConfigErrors errors;
  ConfigReader reader(*root, "", errors);
  auto island = reader.map("island");
  if (!island.has("id")) return fail(ErrorCode::kInvalid, file + ": no island.id");
  const auto id = island.integer("id", 1, 1, model::kMaxIslandId);
  if (!errors.empty()) return fail(ErrorCode::kInvalid, errors.text());
  return OwnerId(static_cast<std::uint32_t>(id));
}

/// The configurations beside the folder, by name: /etc/rubicon/*.yaml. And one that lies elsewhere, unless its name is
/// empty.
std::vector<Found> configurations_of(const fs::path& folder, const std::string& further) {
  std::vector<std::string> files;
  std::error_code error;
  const auto beside = whole_path(folder).parent_path();
  for (const auto& entry : fs::directory_iterator(beside, error)) {
    if (entry.path().extension() == ".yaml") files.push_back(entry.path().string());
  }
  std::sort(files.begin(), files.end());
  const auto is_it = [&](const std::string& file) { return fs::equivalent(file, further, error); };
  if (!further.empty() && std::none_of(files.begin(), files.end(), is_it)) files.push_back(further);
  std::vector<Found> all;
  for (const auto& file : files) {
    if (!is_of_another_realm(file, folder)) all.push_back({file, island_of(file)});
  }
  return all;
}

struct Outcome {
  RealmIdentity realm;
  bool is_new = false;
  std::vector<OwnerId> added;
  std::vector<std::string> faults;  ///< of members that could not be added
  bool given = false;               ///< the key of `local`, to the people of this host
};

bool is_unreadable(const FolderContents& there, std::string_view name) {
  return std::any_of(there.unreadable.begin(), there.unreadable.end(),
                     [name](const auto& one) { return one.name == name; });
}

bool has_people(const FolderContents& there) {
  const auto is_local = [](const auto& one) { return one.member.name == rubicon::trust::kLocalMember; };
  return std::any_of(there.members.begin(), there.members.end(), is_local) ||
         is_unreadable(there, rubicon::trust::kLocalMember);
}

bool has_island(const FolderContents& there, OwnerId island) {
  const auto is_it = [&](const auto& one) { return !one.revoked && one.has_key && one.member.may_use(island); };
  return std::any_of(there.members.begin(), there.members.end(), is_it) ||
         is_unreadable(there, rubicon::trust::member_of_island(island).name);
}

/// The folder has a realm: islands that came since get theirs, and the people if an earlier run was interrupted. What
/// fails for one member is no reason against the others.
Result<Outcome> add_missing(const fs::path& folder, const std::vector<OwnerId>& islands) {
  const auto there = rubicon::trust::show(folder, now());
  if (!there) return fail(there.error());
  if (const auto seen = TrustFolder(folder).check_authority(); !seen && seen.error().code != ErrorCode::kNotFound)
    return fail(seen.error());
  if (const auto safe = TrustFolder(folder).prepare(there->has_authority); !safe) return fail(safe.error());
  Outcome outcome{there->realm, false, {}, {}, false};
  if (!there->has_authority) return outcome;
  for (const auto& one : there->unreadable) outcome.faults.push_back(one.reason);
  if (!has_people(*there)) {
    const auto added = rubicon::trust::add_here(folder, rubicon::trust::member_of_people(), now());
    if (!added) outcome.faults.push_back("no certificate for the people of this host: " + added.error().text);
  }
  for (const auto island : islands) {
    if (has_island(*there, island)) continue;
    const auto added = rubicon::trust::add_here(folder, rubicon::trust::member_of_island(island), now());
    if (added) {
      outcome.added.push_back(island);
    } else {
      outcome.faults.push_back(fmt::format("no certificate for island {}: {}", number(island), added.error().text));
    }
  }
  return outcome;
}

Result<Outcome> make(const fs::path& folder, const std::string& realm, const std::vector<OwnerId>& islands) {
  if (TrustFolder(folder).has_realm()) return add_missing(folder, islands);
  rubicon::trust::InitOptions options;
  if (!realm.empty()) options.realm = realm;
  options.islands = islands;
  auto made = rubicon::trust::init(folder, options, now());
  if (made) return Outcome{std::move(*made), true, islands, {}, false};
  if (!TrustFolder(folder).has_realm()) return fail(made.error());
  return add_missing(folder, islands);
}

std::string numbers(const std::vector<OwnerId>& islands) {
  std::vector<std::uint32_t> all;
  for (const auto one : islands) all.push_back(number(one));
  return fmt::format("{}", fmt::join(all, ", "));
}

void show(Output& out, const Outcome& outcome, const fs::path& folder) {
  put(out, outcome.realm);
  if (!outcome.is_new) {
    const bool is_same = outcome.added.empty() && !outcome.given;
    out.line(
        fmt::format("{} has this realm already{}{}", folder.string(), is_same ? "; nothing was changed" : "",
                    outcome.added.empty() ? "" : "; certificates were added for island " + numbers(outcome.added)));
    if (outcome.given) out.line("the key of local is for the group rubicon now: `sudo adduser USER rubicon`");
    return;
  }
  out.line(fmt::format("{}: a new realm, with certificates for the people of this host (group rubicon){}",
                       folder.string(),
                       outcome.added.empty() ? "; no island is configured yet: run this again when one is"
                                             : ", and for island " + numbers(outcome.added)));
  out.line("next: systemctl restart the islands; `rubicon trust dds add NAME` for another host");
}

/// Errors of a configuration have a line each.
std::string in_one_line(std::string text) {
  for (auto at = text.find('\n'); at != text.npos; at = text.find('\n', at + 1)) text.replace(at, 1, "; ");
  return text;
}

struct Islands {
  std::vector<OwnerId> ids;
  std::vector<std::string> faults;  ///< of configurations that do not say which island they are
};

Islands islands_of(const fs::path& folder, const std::string& further) {
  Islands islands;
  auto& ids = islands.ids;
  for (const auto& one : configurations_of(folder, further)) {
    if (!one.island) {
      islands.faults.push_back(
          fmt::format("no certificate for {}: {}", one.file, in_one_line(one.island.error().text)));
    } else if (std::find(ids.begin(), ids.end(), *one.island) == ids.end()) {
      ids.push_back(*one.island);
    }
  }
  return islands;
}

struct InitCommand {
  std::string realm, island_file;
};

void put_made(Output& out, const Settings& settings, const Outcome& outcome, const fs::path& folder) {
  if (!settings.json) return show(out, outcome, folder);
  Line line{{"realm", as_json(outcome.realm)}, {"folder", folder.string()}, {"new", outcome.is_new}};
  line["given-to-people"] = outcome.given;
  line["islands"] = Line::array();
  for (const auto one : outcome.added) line["islands"].push_back(number(one));
  out.line(model::dump(line));
}

void print_faults(const std::vector<std::string>& faults) {
  for (const auto& one : faults) print_error(printable(one));
}

/// A person who runs it may have made the group since.
void give_to_people(const fs::path& folder, Outcome& outcome) {
  const auto given = rubicon::trust::give_local_to_people(folder);
  if (!given) outcome.faults.push_back(given.error().text);
  outcome.given = given && *given;
}

/// `started`: a unit runs it, before its island. What fails for one member is no reason against its start.
int run(const Settings& settings, const InitCommand& command, const StartedRealm* started) {
  const auto folder = folder_of(settings);
  const bool is_unit = started != nullptr;
  const auto islands = islands_of(folder, command.island_file);
  print_faults(islands.faults);
  auto made = make(folder, command.realm, islands.ids);
  if (!made) {
    const int code = failed_at(folder, made.error());
    return is_unit && TrustFolder(folder).has_realm() ? int{kGood} : code;
  }
  if (!is_unit) give_to_people(folder, *made);
  print_faults(made->faults);
  if (is_unit) {
    if (const auto kept = started->keep(made->realm); !kept) print_error(printable(kept.error().text));
  }
  Output out(1);
  // A unit says only what changed.
  if (!is_unit || made->is_new || !made->added.empty()) put_made(out, settings, *made, folder);
  return ended(out, is_unit || (islands.faults.empty() && made->faults.empty()) ? kGood : kFailed);
}

/// Before an island starts. One without a file does not: a name that was mistyped makes no realm.
int run_for(const Settings& settings, const InitCommand& command) {
  if (std::error_code error; !fs::exists(command.island_file, error) && !error) return kGood;
  const auto folder = folder_of(settings);
  if (is_of_another_realm(command.island_file, folder)) return kGood;
  const StartedRealm started(folder);
  if (const auto there = started.check_is_there(); !there) return failed(there.error());
  return run(settings, command, &started);
}

}  // namespace

void add_init(Cli& cli, CLI::App* parent) {
  const auto [app, options] = cli.command_with<InitCommand>(
      {"init", "Make a realm, with certificates for the people and islands of this host",
       "  sudo rubicon trust dds init\n"
       "  sudo rubicon trust dds init --realm Hall\n"
       "The islands are those of the files *.yaml beside the folder. Run it again after a new one:\n"
       "what is there stays as it is. A member that cannot be made is named, and the others are made; the exit code\n"
       "is 1 then, but with --for 0 if there is a realm.\n",
       parent},
      [](const Settings& settings, const InitCommand& command) {
        return command.island_file.empty() ? run(settings, command, nullptr) : run_for(settings, command);
      });
  app->add_option("--realm", options->realm, "name of the realm; a random end is added; default Rubicon");
  app->add_option("--for", options->island_file,
                  "configuration of an island that starts: nothing is done if it needs no realm of the host, and the "
                  "loss of the realm that it had is an error")
      ->type_name("FILE");
}

}  // namespace rubicon::cli::trust
