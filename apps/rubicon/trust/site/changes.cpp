#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "apps/rubicon/trust/commands.h"
#include "apps/rubicon/trust/site/commands.h"
#include "base/text.h"
#include "model/json_members.h"
#include "trust/member_names.h"
#include "trust/site/site_folder.h"

namespace rubicon::cli::trust::site {

namespace {

namespace sites = rubicon::trust::site;

struct RevokedMember {
  std::string name, folder, reload;
  bool yes = false;
};

struct ChangedMember {
  std::string name, folder;
  std::vector<std::string> roles;
  std::vector<std::uint32_t> islands;
  bool no_roles = false, no_islands = false;
};

std::string reload_command(const sites::BrokerFolder& broker) {
  if (!broker.unit.empty()) return "systemctl reload " + broker.unit;
  return fmt::format("kill -HUP <process of mosquitto -c {}/{}>", broker.setup.folder, sites::kMosquittoFile);
}

/// `systemctl reload UNIT`, to its end.
Result<void> reload_unit(const std::string& unit) {
  std::string systemctl = "systemctl", reload = "reload", end = "--", name = unit;
  char* const words[] = {systemctl.data(), reload.data(), end.data(), name.data(), nullptr};
  pid_t child = 0;
  if (const int error = ::posix_spawnp(&child, "systemctl", nullptr, nullptr, words, environ); error != 0)
    return fail(ErrorCode::kIo, fmt::format("systemctl cannot be run: {}", std::strerror(error)));
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) continue;
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return {};
  return fail(ErrorCode::kIo, fmt::format("systemctl reload {} failed", unit));
}

Result<void> reload_now(const std::string& asked) {
  const auto process = base::parse_number<pid_t>(asked);
  if (!process) return reload_unit(asked);
  if (*process > 1 && ::kill(*process, SIGHUP) == 0) return {};
  return fail(ErrorCode::kIo, fmt::format("process {} does not get the signal to reload: {}", asked,
                                          *process > 1 ? std::strerror(errno) : "expected the number of a broker"));
}

std::vector<std::string> commands_after(const std::vector<BrokerUpdate>& updates) {
  std::vector<std::string> commands;
  for (const auto& one : updates) {
    if (!one.fault) commands.push_back(reload_command(one.broker));
  }
  return commands;
}

/// Asks before it revokes a member of this host, because the user may mean another one. Does not ask scripts.
Result<bool> is_member_meant(const std::filesystem::path& folder, const RevokedMember& options) {
  const auto& name = options.name;
  if (options.yes || !::isatty(STDIN_FILENO) || !rubicon::trust::check_member_name(name)) return true;
  if (!rubicon::trust::FolderFiles(folder).exists(sites::member_key(name))) return true;
  return confirmed(fmt::format("{}'s key is on this host ({}): revoke it for good?", name, folder.string()));
}

int revoke_member(const Settings& settings, const RevokedMember& options) {
  const auto folder = realm_folder(options.folder);
  if (!folder) return failed(folder.error());
  const auto meant = is_member_meant(*folder, options);
  if (!meant) return failed(meant.error());
  if (!*meant) return failed({ErrorCode::kRefused, fmt::format("{} was not revoked", options.name)});
  const auto revoked = sites::revoke(*folder, options.name, now());
  if (!revoked) return failed_at(*folder, revoked.error());
  Output out(1);
  if (!settings.json)
    out.line(
        fmt::format("{} is revoked: members hear it from the programs of this host; a broker knows it when it has "
                    "read its files again",
                    options.name));
  return put_updates(settings, out, *revoked, options.reload);
}

int change_member(const Settings& settings, const ChangedMember& options) {
  const auto folder = realm_folder(options.folder);
  if (!folder) return failed(folder.error());
  std::optional<std::vector<std::string>> roles;
  std::optional<std::vector<OwnerId>> islands;
  if (options.no_roles || !options.roles.empty()) roles = options.roles;
  if (options.no_islands || !options.islands.empty()) islands.emplace();
  for (const auto id : options.islands) islands->push_back(OwnerId(id));
  if (!roles && !islands)
    return failed({ErrorCode::kInvalid, "expected what changes: --role, --no-roles, --island or --no-islands"});
  const auto changed = sites::change(*folder, options.name, roles, islands, now());
  if (!changed) return failed_at(*folder, changed.error());
  Output out(1);
  out.line(settings.json ? model::dump({{"member", as_json(*changed)}}) : "member       " + member_text(*changed));
  return ended(out, kGood);
}

void add_change(Cli& cli, CLI::App* parent) {
  const auto [app, options] =
      cli.command_with<ChangedMember>({"change", "Give a member other roles or islands, in place of those that it has",
                                       "  sudo rubicon trust change hall --role ops --role alarm\n"
                                       "  sudo rubicon trust change hall --no-islands\n",
                                       parent},
                                      change_member);
  app->add_option("NAME", options->name, "name of the member")->required();
  auto* role = app->add_option("--role", options->roles, "role that rights name (may be repeated)");
  role->allow_extra_args(false);
  app->add_flag("--no-roles", options->no_roles, "it has no role any more")->excludes(role);
  auto* island = app->add_option("--island", options->islands, "the member is this island (may be repeated)");
  island->type_name("ID")->allow_extra_args(false)->check(
      CLI::Range(1U, static_cast<unsigned>(model::kMaxIslandId)).description(""));
  app->add_flag("--no-islands", options->no_islands, "it is no island any more")->excludes(island);
  add_realm_option(app, options->folder);
}

}  // namespace

void add_reload_option(CLI::App* app, std::string& asked) {
  app->add_option("--reload", asked, "process or unit of the broker, so that it reads its files again")
      ->type_name("PID|UNIT");
}

int put_updates(const Settings& settings, Output& out, const std::vector<BrokerUpdate>& updates,
                const std::string& asked) {
  int code = kGood;
  for (const auto& one : updates) {
    if (!one.fault) continue;
    code = kFailed;
    print_error(
        printable(fmt::format("the files of the broker were not written: {}; `rubicon trust broker mosquitto` "
                              "writes them again",
                              one.fault->text)));
  }
  const auto commands = commands_after(updates);
  if (settings.json) out.line(model::dump({{"reload", commands}, {"reloaded", !asked.empty()}}));
  out.flush();
  if (!asked.empty()) {
    if (const auto told = reload_now(asked); !told) return failed(told.error());
  } else if (!settings.json) {
    for (const auto& one : commands) out.line("now: " + one);
  }
  return ended(out, code);
}

void add_changes(Cli& cli, CLI::App* parent) {
  const auto [app, options] = cli.command_with<RevokedMember>(
      {"revoke", "Shut a member out for good: from the brokers, and at all other members",
       "  sudo rubicon trust revoke hall\n"
       "Prints how to make the broker read its files again; --reload does it. Asks first, on a terminal,\n"
       "if the key of the member is on this host.\n",
       parent},
      revoke_member);
  app->add_option("NAME", options->name, "name of the member; never given again")->required();
  app->add_flag("--yes", options->yes, "do not ask");
  add_reload_option(app, options->reload);
  add_realm_option(app, options->folder);
  add_change(cli, parent);
}

}  // namespace rubicon::cli::trust::site
