#include <fmt/format.h>

#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <tuple>

#include "apps/rubicon/knx/commands.h"
#include "base/config_reader.h"
#include "config/yaml.h"
#include "networks/knx/groups/group_file.h"
#include "networks/knx/groups/import.h"
#include "networks/knx/project/project.h"
#include "networks/knx/secure/passwords.h"
#include "transport/local_transports.h"
#include "transport/transports.h"

namespace rubicon::cli::knx {

namespace {

using networks::knx::groups::GroupPoint;

struct ImportOptions {
  std::string file, record, output, password_file;
  bool no_guess = false;
};

/// The group file to merge into: its points and secured groups.
Result<void> read_record(const std::string& path, networks::knx::groups::ImportOptions& out) {
  transport::LocalTransports disk;
  const auto text = transport::read_text(disk, path, networks::knx::groups::kMaxListBytes);
  if (!text) return fail(text.error());
  if (text->find_first_not_of(" \t\r\n") == text->npos)
    return fail(
        ErrorCode::kInvalid,
        fmt::format("{} is empty, expected a group file. A shell empties the file behind `>` before this program "
                    "reads it: write with --output",
                    path));
  const auto root = config::parse_yaml(*text, path);
  if (!root) return fail(root.error());
  base::ConfigErrors errors;
  ConfigReader reader(*root, "", errors);
  std::vector<GroupPoint> points;
  networks::knx::groups::read_groups(reader, points);
  out.known_secured = networks::knx::groups::read_secured_groups(reader);
  std::ignore = networks::knx::groups::read_notation(reader);  // the value of the import counts
  reader.finish();
  if (!errors.empty()) return fail(ErrorCode::kInvalid, errors.text());
  out.known = std::move(points);
  return {};
}

/// Replaces the file at once and completely: it may be the file that was merged.
Result<void> replace(const std::string& path, const std::string& text) {
  namespace fs = std::filesystem;
  std::error_code error;
  const auto there = fs::status(path, error);
  if (fs::exists(there) && !fs::is_regular_file(there))
    return fail(ErrorCode::kIo, fmt::format("{} cannot be replaced: it is not a regular file", path));
  const auto target = fs::exists(there) ? fs::canonical(path, error) : fs::path(path);
  const fs::path fresh = fmt::format("{}.{}.new", target.string(), ::getpid());
  std::ofstream file(fresh, std::ios::binary | std::ios::trunc);
  file << text;
  file.close();
  error.clear();
  if (file && fs::exists(there)) fs::permissions(fresh, there.permissions(), error);
  if (file && !error) fs::rename(fresh, target, error);
  if (file && !error) return {};
  const auto why = error ? error.message() : std::string("the folder is missing or not writable, or the disk is full");
  fs::remove(fresh, error);
  return fail(ErrorCode::kIo, fmt::format("{}: cannot be written: {}", path, why));
}

int put(const ImportOptions& options, const std::string& text) {
  if (options.output.empty()) {
    Output out(1);
    out.write(text);
    return ended(out, kGood);
  }
  const auto written = replace(options.output, text);
  if (!written) print_error(written.error().text);
  return written ? kGood : kFailed;
}

/// The points of a project or of a list; the content of the file decides which it is.
Result<networks::knx::groups::Import> read_file(const ImportOptions& options,
                                                const networks::knx::groups::ImportOptions& how) {
  namespace project = networks::knx::project;
  namespace secure = networks::knx::secure;
  transport::LocalTransports disk;
  auto file = disk.open_file(options.file);
  const auto is_project = file ? project::is_project(**file, options.file) : Result<bool>(false);
  if (!is_project) return fail(is_project.error());
  if (!*is_project && !options.password_file.empty())
    return fail(ErrorCode::kInvalid, "--password-file is only for projects of ETS (.knxproj)");
  if (!*is_project) return networks::knx::groups::import_file(options.file, how);
  const auto password = secure::find_password(disk, options.password_file, secure::kPasswordVariable);
  if (!password) return fail(password.error());
  const auto* given = password->has_value() ? &**password : nullptr;
  auto imported =
      project::import_project(std::move(*file), std::filesystem::path(options.file).filename().string(), {given}, how);
  if (!imported && imported.error().code == ErrorCode::kRefused)
    return fail(imported.error().code,
                imported.error().text + (given != nullptr
                                             ? secure::password_source(*given, options.password_file)
                                             : fmt::format(": give it with --password-file FILE, or in the environment "
                                                           "variable {}",
                                                           secure::kPasswordVariable)));
  return imported;
}

/// Writes the group file to standard output or to --output, the report to standard error. Without any address the
/// group file of yesterday stays. kPartly: some lines have errors.
int import(const ImportOptions& options) {
  networks::knx::groups::ImportOptions how;
  how.guess = !options.no_guess;
  if (!options.record.empty()) {
    if (const auto known = read_record(options.record, how); !known) {
      print_error(known.error().text);
      return kUsage;
    }
  }
  const auto imported = read_file(options, how);
  if (!imported) {
    print_error(imported.error().text);
    return kFailed;
  }
  std::fputs(report_text(imported->report).c_str(), stderr);
  if (imported->report.taken == 0) {
    print_error("no group address was imported: nothing is written");
    return kFailed;
  }
  const int written = put(options, networks::knx::groups::to_yaml(imported->points, imported->report.source,
                                                                  imported->secured, imported->report.notation));
  return written == kGood && imported->report.errors > 0 ? kPartly : written;
}

}  // namespace

void add_import(Cli& cli, CLI::App* under) {
  const auto options = std::make_shared<ImportOptions>();
  auto* app = cli.command(
      {"import", "Convert a project or an export of ETS to a group file (YAML)",
       "  rubicon knx import flat.csv > flat.yaml                # CSV, XML or ESF; the report goes to stderr\n"
       "  rubicon knx import hall.knxproj --password-file project.password --output hall.yaml\n"
       "  rubicon knx import new.csv --merge flat.yaml --output flat.yaml   # keeps what is in flat.yaml\n"
       "Never `--merge flat.yaml > flat.yaml`: the shell empties flat.yaml before it is read.\n"
       "Exit code 9: the group file is written, but some lines have errors, and are not in it.\n",
       under},
      [options](const Settings&) { return import(*options); });
  app->add_option("FILE", options->file,
                  "a project of ETS (.knxproj), or an export of its group addresses: CSV, XML or ESF")
      ->required();
  app->add_option("--password-file", options->password_file,
                  "holds the password of the project, for you alone (chmod 600); without it the environment variable "
                  "RUBICON_KNX_PASSWORD may")
      ->type_name("FILE");
  app->add_flag("--no-guess", options->no_guess, "do not infer from names which addresses belong together");
  app->add_option("--output", options->output, "write the group file here instead of to standard output")
      ->type_name("FILE");
  app->add_option("--merge", options->record, "a group file written before; its ids are kept")->type_name("FILE");
}

}  // namespace rubicon::cli::knx
