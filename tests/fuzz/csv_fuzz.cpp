#include <cstdlib>

#include "fuzz_target.h"
#include "networks/log/foreign_recordings.h"

namespace rubicon::fuzz::csv_fuzz {

namespace {

using namespace rubicon::networks::log;

ColumnMapping column(const TypeCatalogue& types, const char* name, const char* type) {
  ColumnMapping mapping;
  mapping.column = name;
  mapping.form.type = types.find(type);
  mapping.form.scale = 2;
  mapping.capability.point = {Kind::kSensor, mapping.form.type->id, "1"};
  return mapping;
}

/// A mapping of numbers, words and text; the settings byte chooses header, times and separators.
CsvMapping mapping_of(const TypeCatalogue& types, std::uint8_t settings) {
  CsvMapping mapping;
  mapping.comment = (settings & 1) != 0 ? "#" : "";
  mapping.header_lines = (settings >> 1) & 1;
  mapping.names_from_comment = (settings & 5) == 5 ? "Columns" : "";
  mapping.separators = (settings & 8) != 0 ? ", " : ",;\t";
  if ((settings & 16) != 0) mapping.time_column = "time";
  mapping.time_unit = static_cast<TimeUnit>((settings >> 5) & 7);
  mapping.period = std::chrono::seconds(1);
  DeviceMapping device;
  device.device = "d";
  device.columns = {column(types, "2", "temperature"), column(types, "b", "contact"), column(types, "c", "button"),
                    column(types, "d", "lightRaw"), column(types, "5", "text")};
  PropertyMapping label;
  label.source = PropertyMapping::Source::kComment;
  label.text = "Task";
  label.form.type = types.find("label");
  device.properties = {label};
  mapping.devices = {device};
  return mapping;
}

}  // namespace

/// Input: settings, size of the pieces, then the content of a table.
FUZZ_TARGET(csv) {
  static const TypeCatalogue types;
  if (size < 2) return 0;
  ReplayCounters counters;
  CsvRecording recording(mapping_of(types, data[0]), counters, [](std::uint64_t, std::string_view) {});
  ReplayClock clock(1, std::nullopt, {});
  const ByteView content(data + 2, size - 2);
  const std::size_t piece = data[1] + std::size_t{1};
  recording.begin("fuzz_1.csv", {});
  const auto drain = [&] {
    while (const auto step = recording.next()) clock.due(clock.advance(step->time));
  };
  for (std::size_t at = 0; at < content.size(); at += piece) {
    recording.feed(content.subspan(at, std::min(piece, content.size() - at)));
    drain();
  }
  recording.end();
  drain();
  if (counters.lines > content.size()) std::abort();
  return 0;
}

}  // namespace rubicon::fuzz::csv_fuzz
