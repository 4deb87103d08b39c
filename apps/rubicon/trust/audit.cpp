#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/stat.h>
#include <time.h>

#include <algorithm>
#include <fstream>

#include "apps/rubicon/trust/commands.h"
#include "apps/rubicon/trust/site/commands.h"
#include "base/config_reader.h"
#include "config/config_file.h"
#include "config/rights_config.h"
#include "model/json_members.h"
#include "rights/audit.h"

namespace rubicon::cli::trust {

namespace {

namespace fs = std::filesystem;
using rubicon::rights::AuditQuery;

/// How often the file is looked at while it is followed.
constexpr timespec kLook{0, 250'000'000};

struct AuditOptions {
  std::string file;
  AuditQuery query;
  bool follow = false;
};

/// Where the island of a configuration writes it; empty: to its log only.
Result<std::string> file_of_island(const std::string& configuration) {
  const auto root = config::load_config(configuration, {});
  if (!root) return fail(root.error());
  base::ConfigErrors errors;
  ConfigReader reader(*root, "", errors);
  const auto named = config::read_audit(reader).file;
  const auto state = reader.map("state").text("file", "");
  const auto file = !named.empty() ? named : state.empty() ? state : state + ".audit";
  if (file.empty()) return file;
  return (fs::path(configuration).parent_path() / file).string();
}

std::vector<std::string> configurations(const Settings& settings) {
  if (!settings.config.empty()) return {settings.config};
  std::vector<std::string> all;
  std::error_code error;
  const auto realm = site::realm_folder("");
  const auto beside = fs::absolute(realm ? *realm : fs::path(), error).lexically_normal().parent_path();
  for (const auto& entry : fs::directory_iterator(beside, error)) {
    if (entry.path().extension() == ".yaml") all.push_back(entry.path().string());
  }
  std::sort(all.begin(), all.end());
  return all;
}

/// The only one on this host.
Result<std::string> find_audit(const Settings& settings) {
  std::vector<std::string> files;
  for (const auto& one : configurations(settings)) {
    const auto file = file_of_island(one);
    if (!file && !settings.config.empty()) return fail(file.error());
    if (file && !file->empty()) files.push_back(*file);
  }
  if (files.size() == 1) return files.front();
  return fail(ErrorCode::kInvalid,
              files.empty()
                  ? std::string("no island of this host has an audit log, expected --file FILE or --config FILE")
                  : fmt::format("several islands of this host have audit logs, expected --file with one of: {}",
                                fmt::join(files, ", ")));
}

/// `2026-01-31 12:00:00 CET  desk set proxy.hall.door.actuator.lock-1.command = open: refused, through island-2, ...`
std::string audit_text(std::string_view text) {
  const auto line = model::object_of(text);
  const auto of = [&line](const char* name) { return printable(model::text_of(line, name)); };
  const auto time = time_text(model::time_from_seconds(model::number_of(line, "t")));
  if (line.contains("lost"))
    return fmt::format("{}  {} before could not be written", time, counted(model::count_of(line, "lost"), "line"));
  if (line.contains("more"))
    return fmt::format("{}  {}: refused {} more", time, of("who"), counted(model::count_of(line, "more"), "time"));
  const auto value = of("value"), through = of("through"), why = of("why");
  return fmt::format("{}  {} {} {}{}: {}{}{}", time, of("who"), of("verb"), of("key"),
                     value.empty() ? "" : " = " + value, of("verdict"), through.empty() ? "" : ", through " + through,
                     why.empty() ? "" : ", " + why);
}

bool is_wanted(const AuditQuery& query, std::string_view text) {
  const auto line = model::object_of(text);
  if (!query.who.empty() && model::text_of(line, "who") != query.who) return false;
  return !query.refused_only || model::text_of(line, "verdict") == "refused";
}

ino_t number_of_file(const std::string& file) {
  struct stat about {};
  return ::stat(file.c_str(), &about) == 0 ? about.st_ino : 0;
}

/// New lines as they are written, also in the file that replaces this one, until the reader of our output ends.
void follow_audit(Output& out, bool json, const AuditOptions& options, std::uint64_t begin) {
  auto opened = number_of_file(options.file);
  std::ifstream lines(options.file, std::ios::binary);
  lines.seekg(static_cast<std::streamoff>(begin));
  std::string whole;
  while (!out.broken()) {
    const auto there = number_of_file(options.file);  // before the last lines of a file that was replaced
    for (std::string part; std::getline(lines, part);) {
      whole += part;
      if (lines.eof()) break;  // the rest of this line is still to come
      if (is_wanted(options.query, whole)) out.line(json ? whole : audit_text(whole));
      whole.clear();
    }
    lines.clear();
    out.flush();
    if (there == opened || there == 0) {
      ::nanosleep(&kLook, nullptr);
      continue;
    }
    opened = there;
    lines = std::ifstream(options.file, std::ios::binary);
  }
}

int audit(const Settings& settings, const AuditOptions& asked) {
  auto options = asked;
  if (options.file.empty()) {
    auto found = find_audit(settings);
    if (!found) return failed(found.error());
    options.file = std::move(*found);
  }
  Output out(1);
  const auto read = rubicon::rights::read_audit(options.file, options.query, [&](std::string_view line) {
    out.line(settings.json ? std::string(line) : audit_text(line));
  });
  if (!read) return failed(read.error());
  out.flush();
  if (read->damaged > 0) print_error(fmt::format("{}: {} damaged", options.file, counted(read->damaged, "line")));
  if (options.follow) follow_audit(out, settings.json, options, read->end);
  return ended(out, kGood);
}

}  // namespace

void add_audit(Cli& cli, CLI::App* parent) {
  const auto [app, options] = cli.command_with<AuditOptions>(
      {"audit", "Show the requests to an island of this host, who sent them, and how they ended",
       "  sudo rubicon trust audit\n"
       "  sudo rubicon trust audit --name desk --refused\n"
       "  sudo rubicon trust audit --follow --json\n",
       parent},
      audit);
  app->add_option("--file", options->file,
                  "audit log; default: the log of the only island of this host, or of the one in --config")
      ->type_name("FILE");
  app->add_option("--name", options->query.who, "only what this member asked for");
  app->add_flag("--refused", options->query.refused_only, "only what was refused");
  app->add_flag("--follow", options->follow, "go on with new lines");
}

}  // namespace rubicon::cli::trust
