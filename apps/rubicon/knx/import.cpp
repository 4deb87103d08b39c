#include <fmt/format.h>

#include <cstdio>

#include "apps/rubicon/knx/commands.h"
#include "base/config_reader.h"
#include "networks/knx/groups/import.h"
#include "networks/knx/groups/record.h"
#include "runtime/yaml.h"
#include "transport/local_transports.h"
#include "transport/read_text.h"

namespace rubicon::cli::knx {

namespace {

using networks::knx::GroupPoint;

struct Options {
  std::string file, record;
  bool no_guess = false;
};

Result<std::vector<GroupPoint>> read_record(const std::string& path) {
  transport::LocalTransports disk;
  const auto text = transport::read_text(disk, path, networks::knx::kMaxListBytes);
  if (!text) return fail(text.error());
  const auto root = runtime::parse_yaml(*text, path);
  if (!root) return fail(root.error());
  base::ConfigErrors errors;
  ConfigReader reader(*root, "", errors);
  std::vector<GroupPoint> points;
  networks::knx::read_groups(reader, points);
  reader.finish();
  if (!errors.empty()) return fail(ErrorCode::kInvalid, errors.text());
  return points;
}

/// The record goes to standard output, the report to standard error.
int import(const Options& options) {
  networks::knx::ImportOptions how;
  how.guess = !options.no_guess;
  if (!options.record.empty()) {
    auto known = read_record(options.record);
    if (!known) {
      say(known.error().text);
      return kUsage;
    }
    how.known = std::move(*known);
  }
  const auto imported = networks::knx::import_file(options.file, how);
  if (!imported) {
    say(imported.error().text);
    return kFailed;
  }
  Output out(1);
  out.write(networks::knx::to_yaml(imported->points, imported->report.source));
  out.flush();
  std::fputs(report_text(imported->report).c_str(), stderr);
  return out.error().empty() ? kGood : kFailed;
}

}  // namespace

void add_import(Cli& cli, CLI::App* under) {
  const auto options = std::make_shared<Options>();
  auto* app =
      cli.command({"import", "Turn an ETS export of group addresses into configuration",
                   "  rubicon knx import flat.csv > flat.yaml                # CSV, XML or ESF; the report: stderr\n"
                   "  rubicon knx import flat.csv --merge flat.yaml > new.yaml   # what flat.yaml says stays\n",
                   under},
                  [options](const Settings&) { return import(*options); });
  app->add_option("FILE", options->file, "export of ETS: CSV, XML or ESF")->required();
  app->add_flag("--no-guess", options->no_guess, "do not guess by names which addresses belong together");
  app->add_option("--merge", options->record, "a record written before: its ids stay")->type_name("FILE");
}

}  // namespace rubicon::cli::knx
