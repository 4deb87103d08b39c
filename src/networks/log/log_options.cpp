#include "networks/log/log_options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>

#include "base/text.h"
#include "networks/log/replay_clock.h"

namespace rubicon::networks::log {

namespace {

/// Keys that only tables have. With one of them and no `format`, the user probably meant a table.
constexpr const char* kTableKeys[] = {
    "map", "period", "time", "header", "separators", "start-time", "comment", "names-from-comment", "decimal", "zone"};

/// Why the options seem to describe a table; empty = they do not.
std::string table_hint(ConfigReader& options, const LogOptions& out) {
  std::vector<std::string> keys;
  for (const auto* key : kTableKeys) {
    if (options.has(key)) keys.emplace_back(key);
  }
  if (!keys.empty()) return fmt::format("only tables have {}", fmt::join(keys, ", "));
  const bool has_csv_name = !out.files.empty() && out.files.front().ends_with(".csv");
  return has_csv_name ? fmt::format("the file is {}", out.files.front()) : std::string();
}

void read_files(ConfigReader& options, LogOptions& out) {
  if (options.has("file") && options.has("files")) options.error("file", "given together with files, expected one");
  out.one_file = !options.has("files");
  out.files = options.texts(options.has("file") ? "file" : "files");
  if (out.files.empty()) options.error("file", "missing, expected a path (or files: a list of paths)");
  for (const std::string& file : out.files) {
    if (file.empty()) options.error(options.has("file") ? "file" : "files", "empty path, expected a file");
  }
}

void read_speed(ConfigReader& options, LogOptions& out) {
  const auto speed = parse_replay_speed(options.text("speed", "1"));
  if (speed)
    out.speed = *speed;
  else
    options.error("speed", speed.error().text);
}

void read_pacing(ConfigReader& options, LogOptions& out) {
  read_speed(options, out);
  out.loop = options.boolean("loop", false);
  out.start = options.duration("start", Duration::zero());
  if (options.has("longest-gap")) out.longest_gap = options.duration("longest-gap", Duration::zero());
  if (options.has("between-files")) out.between_files = options.duration("between-files", Duration::zero());
  const std::string end = options.choice("end", "hold", {"hold", "leave", "stop"});
  out.end = end == "leave" ? LogOptions::End::kLeave : end == "stop" ? LogOptions::End::kStop : LogOptions::End::kHold;
  out.deadline = options.duration_or_never("deadline", out.deadline).value_or(Duration::zero());
  out.recorded_times = options.choice("times", "recorded", {"recorded", "replay"}) == "recorded";
}

void read_motes(ConfigReader& options, LogOptions& out) {
  const std::string board = options.choice("board", "STANDARD", {"STANDARD", "EM1000", "SE1000", "IRIS", "MICAZ"});
  out.calibration.board = motes::parse_board(board).value_or(motes::Board::kStandard);
  const std::string units = options.choice("units", "physical", {"physical", "raw", "both"});
  out.calibration.units = motes::parse_units(units).value_or(motes::Units::kPhysical);
  out.calibration.temperature_at_zero =
      options.real("temperature-at-zero", out.calibration.temperature_at_zero, -50, 0);
  out.calibration.threshold =
      static_cast<std::uint16_t>(options.integer("threshold", out.calibration.threshold, 1, 4095));
}

void resolve_tables(CsvMapping& mapping, const std::string& directory) {
  for (DeviceMapping& device : mapping.devices) {
    for (PropertyMapping& property : device.properties) {
      if (property.source == PropertyMapping::Source::kTable)
        property.text = std::filesystem::path(base::resolve_path(directory, property.text)).lexically_normal().string();
    }
  }
}

}  // namespace

LogOptions read_log_options(const network::NetworkConfig& config) {
  ConfigReader& options = config.options;
  LogOptions out;
  out.directory = config.directory;
  read_files(options, out);
  read_pacing(options, out);
  using Format = LogOptions::Format;
  const auto format = options.choice("format", "", {"packets", "csv", "recording"});
  out.format = format == "packets"     ? Format::kPackets
               : format == "csv"       ? Format::kCsv
               : format == "recording" ? Format::kTuples
                                       : Format::kDetect;
  if (const auto why = table_hint(options, out); format.empty() && !why.empty()) {
    options.error("", fmt::format("'format' is missing, expected csv ({}), packets or recording", why));
    out.format = Format::kCsv;
  }
  if (out.format == Format::kCsv) {
    out.csv = read_csv_mapping(options, config.types);
    resolve_tables(*out.csv, config.directory);
  }
  if (out.format == Format::kTuples || out.format == Format::kDetect) out.network = options.text("network", "");
  if (out.format == Format::kPackets || out.format == Format::kDetect) read_motes(options, out);
  return out;
}

}  // namespace rubicon::networks::log
