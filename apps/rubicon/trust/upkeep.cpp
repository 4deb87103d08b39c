#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <optional>

#include "apps/rubicon/session.h"
#include "apps/rubicon/trust/commands.h"
#include "apps/rubicon/trust/phrase.h"
#include "model/json_members.h"
#include "trust/trust_folder.h"

namespace rubicon::cli::trust {

namespace {

using rubicon::trust::FolderContents;
using rubicon::trust::ListedMember;

/// Soon enough to renew in peace.
constexpr int kWarnDays = 30;

struct RevokeOptions {
  std::string name;
  bool yes = false;
};

struct RenewOptions {
  std::string name;
  int days = rubicon::trust::kMemberDays;
};

/// A list that is published reaches every component that is there by then.
constexpr Duration kTelling = std::chrono::seconds(2);

/// Takes part for a moment, and counts who is present: whoever is a member hands the list on. Islands of this host see
/// the file too.
std::size_t tell_the_others(const Settings& settings) {
  auto options = settings.options;
  options.name = "rubicon trust dds revoke";
  auto client = Client::open(options);
  if (!client) return 0;
  (*client)->run_until([] { return false; }, kTelling);
  return (*client)->components().size();
}

/// A member of this host is easily meant otherwise: an island, or `local`, by which its people take part. Scripts are
/// not asked.
Result<bool> is_meant(const std::filesystem::path& folder, const RevokeOptions& options) {
  const auto& name = options.name;
  if (options.yes || !::isatty(STDIN_FILENO) || !rubicon::trust::check_member_name(name)) return true;
  if (!rubicon::trust::FolderFiles(folder).exists(rubicon::trust::key_file(name))) return true;
  return confirmed(fmt::format("{}'s key is on this host ({}): revoke it for good?", name, folder.string()));
}

int revoke(const Settings& settings, const RevokeOptions& options) {
  const auto& name = options.name;
  const auto folder = folder_of(settings);
  const auto meant = is_meant(folder, options);
  if (!meant) return failed(meant.error());
  if (!*meant) return failed({ErrorCode::kRefused, fmt::format("{} was not revoked", name)});
  const auto revoked = rubicon::trust::revoke(folder, name, now());
  if (!revoked) return failed_at(folder, revoked.error());
  const auto present = tell_the_others(settings);
  Output out(1);
  if (settings.json) {
    out.line(model::dump({{"revoked", name}, {"present", present}}));
  } else {
    out.line(fmt::format("{} is revoked; {} heard it now ({}); others learn it from any member that they meet", name,
                         present == 1 ? "1 component" : fmt::format("{} components", present),
                         settings.options.interfaces.empty() ? "other networks: --interfaces" : "on its interfaces"));
  }
  return ended(out, kGood);
}

/// Those of this host in their place, the others by a file.
Result<Line> renew_one(const std::filesystem::path& folder, const std::string& name, bool here, int days) {
  std::optional<NewFile> file;
  if (!here) {
    auto opened = NewFile::open(name + ".trust");
    if (!opened) return fail(opened.error());
    file.emplace(std::move(*opened));
  }
  const auto issued = rubicon::trust::renew(folder, name, days, now());
  if (!issued) return fail(issued.error());
  Line line{{"member", as_json(issued->member)}};
  if (!file) return line;
  if (const auto written = file->write(issued->bundle); !written) return fail(written.error());
  line["file"] = file->path();
  return line;
}

bool is_asked_for(const RenewOptions& options, const std::string& name, bool revoked) {
  return options.name.empty() ? !revoked : name == options.name;
}

/// One whose certificate cannot be read cannot be renewed: ids, roles and key of the next one come from it.
std::size_t refuse_unreadable(const FolderContents& there, const RenewOptions& options) {
  std::size_t refused = 0;
  for (const auto& one : there.unreadable) {
    if (!is_asked_for(options, one.name, one.revoked)) continue;
    print_error(printable(fmt::format("{} cannot be renewed: {}", one.name, one.reason)));
    ++refused;
  }
  return refused;
}

std::string renewed_text(const ListedMember& one) {
  const auto& name = one.member.name;
  return fmt::format("{:<12} {}", name,
                     one.has_key ? "renewed; islands of this host: systemctl reload 'rubicon-proxy@*'"
                                 : fmt::format("{}.trust: rubicon trust dds join it on its host", name));
}

int renew(const Settings& settings, const RenewOptions& options) {
  const auto folder = folder_of(settings);
  const auto there = rubicon::trust::show(folder, now());
  if (!there) return failed_at(folder, there.error());
  Output out(1);
  auto done = refuse_unreadable(*there, options);
  int code = done == 0 ? kGood : kFailed;
  for (const auto& one : there->members) {
    if (!is_asked_for(options, one.member.name, one.revoked.has_value())) continue;
    ++done;
    const auto line = renew_one(folder, one.member.name, one.has_key, options.days);
    if (!line) {
      code = failed_at(folder, line.error());
    } else {
      out.line(settings.json ? model::dump(*line) : renewed_text(one));
    }
  }
  if (done > 0) return ended(out, code);
  return failed({ErrorCode::kNotFound, fmt::format("{}: no member {}, expected one that `rubicon trust dds show` lists",
                                                   folder.string(), options.name.empty() ? "is there" : options.name)});
}

Line listed_json(const ListedMember& one) {
  auto line = as_json(one.member);
  line["days-left"] = one.days_left;
  line["has-key"] = one.has_key;
  if (one.revoked) line["revoked"] = model::seconds_json(*one.revoked);
  return line;
}

Line contents_json(const FolderContents& there, const std::filesystem::path& folder) {
  Line line{{"realm", as_json(there.realm)},
            {"folder", folder.string()},
            {"authority", there.has_authority},
            {"authority-days-left", there.authority_days_left},
            {"revoked-number", there.revoked_number},
            {"members", Line::array()},
            {"unreadable", Line::array()}};
  for (const auto& one : there.members) line["members"].push_back(listed_json(one));
  for (const auto& one : there.unreadable) line["unreadable"].push_back({{"name", one.name}, {"why", one.reason}});
  return line;
}

std::string state_of(const ListedMember& one) {
  if (one.revoked) return "revoked";
  if (one.days_left < 0) return "expired";
  if (one.days_left < kWarnDays) return fmt::format("{} days left", one.days_left);
  return "good";
}

std::string table_of(const Output& out, const std::vector<ListedMember>& members) {
  Table table({{"member"}, {"ids"}, {"roles"}, {"until"}, {"key"}, {"state"}});
  for (const auto& one : members) {
    table.row({one.member.name, ids_text(one.member), fmt::format("{}", fmt::join(one.member.roles, ", ")),
               time_text(one.member.expires).substr(0, 10), one.has_key ? "here" : "elsewhere", state_of(one)});
  }
  return table.text({out.has_colour(), out.width()});
}

int show(const Settings& settings) {
  const auto folder = folder_to_show(settings);
  const auto there = rubicon::trust::show(folder, now());
  if (!there) return failed_at(folder, there.error());
  Output out(1);
  if (settings.json) {
    out.line(model::dump(contents_json(*there, folder)));
  } else {
    put(out, there->realm);
    out.line(fmt::format("folder       {}{}", folder.string(),
                         there->has_authority ? ", with the authority: members are added here" : ""));
    out.write(table_of(out, there->members));
  }
  put_unreadable(*there);
  return ended(out, kGood);
}

}  // namespace

void add_revoke(Cli& cli, CLI::App* parent) {
  const auto [app, options] = cli.command_with<RevokeOptions>(
      {"revoke", "Shut a member out, at once and for good",
       "  sudo rubicon trust dds revoke desk\n"
       "Components that are there end their connections to it; those that are not, when they hear\n"
       "any member again. Asks first, on a terminal, if the key of the member is on this host.\n",
       parent},
      revoke);
  app->add_option("NAME", options->name, "name of the member; never given again")->required();
  app->add_flag("--yes", options->yes, "do not ask");
}

void add_renew(Cli& cli, CLI::App* parent) {
  const auto [app, options] = cli.command_with<RenewOptions>(
      {"renew", "Give members new certificates before theirs end; they keep names, ids and keys",
       "  sudo rubicon trust dds renew                # all\n"
       "  sudo rubicon trust dds renew desk           # writes desk.trust, for `join` there\n",
       parent},
      renew);
  app->add_option("NAME", options->name, "name of the member; default all that are not revoked");
  app->add_option("--days", options->days, "life of the certificates")
      ->type_name("N")
      ->check(CLI::Range(1, rubicon::trust::kMaxMemberDays).description(""))
      ->capture_default_str();
}

void add_show(Cli& cli, CLI::App* parent) {
  cli.command({"show", "Show the realm of a folder, its fingerprint and its members, without secrets",
               "  rubicon trust dds show\n"
               "  rubicon trust dds show --json\n",
               parent},
              [](const Settings& settings) { return show(settings); });
}

}  // namespace rubicon::cli::trust
