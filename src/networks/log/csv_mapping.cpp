#include "networks/log/csv_mapping.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/text.h"
#include "model/type_catalogue.h"
#include "networks/log/file_time.h"

namespace rubicon::networks::log {

namespace {

constexpr std::string_view kTimeUnits[] = {"us", "ms", "s", "min", "h", "unix", "unix-ms", "iso"};
constexpr double kFurthestMicroseconds = 4e18;

/// Fills in the point and type that `light-window` names; reports mistakes to the reader.
const Type* read_point(ConfigReader& reader, const std::string& key, const std::string& text, Kind kind,
                       const TypeCatalogue& types, model::Capability& capability) {
  const std::size_t dash = text.find('-');
  const std::string type_name = text.substr(0, dash);
  const std::string instance = dash == std::string::npos ? "" : text.substr(dash + 1);
  const Type* type = types.find(type_name);
  if (type == nullptr) {
    reader.error(key, model::unknown_type_text(types, type_name));
    return nullptr;
  }
  if (kind == Kind::kSensor && instance.empty()) {
    reader.error(key, fmt::format("`{}`, expected type and instance, for example `{}-1`", text, type_name));
    return nullptr;
  }
  capability.point = {kind, type->id, instance};
  capability.type_name = type->name;
  capability.access = model::Access::kRead;
  return type;
}

std::map<std::string, std::string> read_words(ConfigReader& reader) {
  std::map<std::string, std::string> words;
  if (!reader.has("words")) return words;
  ConfigReader map = reader.map("words");
  for (const std::string& key : map.keys()) words[key] = map.text(key, "");
  return words;
}

/// Values are converted to the unit of the type; a type without a unit takes that of the table.
void read_unit(ConfigReader& reader, ColumnMapping& mapping) {
  const std::string unit = reader.text("unit", "");
  const Type* type = mapping.form.type;
  if (unit.empty() || type == nullptr || unit == type->unit) return;
  if (type->unit == "1") {
    mapping.capability.unit = unit;
    return;
  }
  mapping.form.unit = model::conversion(unit, type->unit);
  if (mapping.form.unit) return;
  const std::string others = model::units_of(type->unit);
  reader.error("unit", fmt::format("`{}` does not convert to the unit of {}, expected {}{}{}", unit, type->name,
                                   type->unit, others.empty() ? "" : " or one of ", others));
}

ColumnMapping read_column(std::string column, ConfigReader& reader, const TypeCatalogue& types) {
  ColumnMapping mapping;
  mapping.column = std::move(column);
  const std::string sensor = reader.required_text("sensor", "type and instance, such as temperature-1");
  if (!sensor.empty())
    mapping.form.type = read_point(reader, "sensor", sensor, Kind::kSensor, types, mapping.capability);
  mapping.form.scale = reader.real("scale", 1);
  mapping.form.offset = reader.real("offset", 0);
  mapping.form.words = read_words(reader);
  read_unit(reader, mapping);
  reader.finish();
  return mapping;
}

PropertyMapping read_property(const std::string& id, ConfigReader& reader, const TypeCatalogue& types) {
  PropertyMapping mapping;
  mapping.form.type = read_point(reader, "", id, Kind::kProperty, types, mapping.capability);
  mapping.capability.deadline = Duration::zero();
  mapping.form.words = read_words(reader);
  const std::pair<const char*, PropertyMapping::Source> kSources[] = {
      {"value", PropertyMapping::Source::kFixed},
      {"from-comment", PropertyMapping::Source::kComment},
      {"from-table", PropertyMapping::Source::kTable}};
  int given = 0;
  for (const auto& [key, source] : kSources) {
    if (!reader.has(key)) continue;
    mapping.source = source;
    mapping.text = reader.required_text(key);
    ++given;
  }
  if (given != 1) reader.error("", "expected exactly one of value, from-comment, from-table");
  reader.finish();
  return mapping;
}

DeviceMapping read_device(std::string id, ConfigReader& reader, const TypeCatalogue& types) {
  DeviceMapping device;
  device.device = std::move(id);
  device.name = reader.text("name", "");
  device.model = reader.text("model", "");
  for (auto& [column, entry] : reader.maps("columns")) device.columns.push_back(read_column(column, entry, types));
  for (auto& [property, entry] : reader.maps("properties"))
    device.properties.push_back(read_property(property, entry, types));
  if (device.columns.empty()) reader.error("columns", "missing or empty, expected a map of columns to sensors");
  reader.finish();
  return device;
}

void read_header(ConfigReader& options, CsvMapping& mapping) {
  const std::string header = options.text("header", "yes");
  if (header == "yes" || header == "no") {
    mapping.header_lines = header == "yes" ? 1 : 0;
  } else {
    const auto count = number_of(header);
    if (!count || *count < 0 || *count > 1000 || *count != std::floor(*count))
      options.error("header", fmt::format("`{}`, expected yes, no or a number of lines up to 1000", header));
    else
      mapping.header_lines = static_cast<std::size_t>(*count);
  }
}

void read_zone(ConfigReader& options, CsvMapping& mapping) {
  const auto name = options.text("zone", "UTC");
  auto zone = TimeZone::load(name);
  if (!zone) return options.error("zone", zone.error().text);
  mapping.zone = std::move(*zone);
}

/// With a decimal comma it separates no cells.
void read_separators(ConfigReader& options, CsvMapping& mapping) {
  mapping.decimal = options.choice("decimal", ".", {".", ","})[0];
  if (mapping.decimal == ',') mapping.separators = ";\t";
  mapping.separators = options.text("separators", mapping.separators);
  if (mapping.separators.empty()) options.error("separators", "empty, expected characters, for example \",;\"");
  if (mapping.separators.find(mapping.decimal) != std::string::npos)
    options.error(
        "separators",
        fmt::format("`{}` is the decimal sign too (`decimal`), expected others, for example \";\"", mapping.decimal));
}

void read_times(ConfigReader& options, CsvMapping& mapping) {
  if (options.has("time")) {
    ConfigReader time = options.map("time");
    mapping.time_column = time.required_text("column", "the name of the column with the times, such as time");
    const std::string unit = time.choice("unit", "s", {"us", "ms", "s", "min", "h", "unix", "unix-ms", "iso"});
    const auto* found = std::find(std::begin(kTimeUnits), std::end(kTimeUnits), unit);
    mapping.time_unit = static_cast<TimeUnit>(found - std::begin(kTimeUnits));
    mapping.time_format = time.text("format", "");
    if (!mapping.time_format.empty()) mapping.time_unit = TimeUnit::kIso;
    if (!mapping.time_format.empty() && time.has("unit")) time.error("format", "expected `format` or `unit`, not both");
    time.finish();
  }
  mapping.period = std::chrono::floor<RecordTime>(options.duration("period", Duration::zero()));
  if (mapping.time_column.empty() && mapping.period <= RecordTime{0})
    options.error("period", "missing, expected `time: {column: .., unit: ..}` or a period, for example 250ms");
  const std::string start = options.text("start-time", "");
  if (start.empty()) return;
  const auto read = parse_iso_time(start);
  if (!read)
    return options.error("start-time", fmt::format("`{}`, expected a time, for example 2026-01-31T12:00:00Z", start));
  mapping.start_time = read->is_local && mapping.zone ? mapping.zone->moment_of(read->time, std::nullopt) : read->time;
}

}  // namespace

CsvMapping read_csv_mapping(ConfigReader& options, const TypeCatalogue& types) {
  CsvMapping mapping;
  mapping.comment = options.text("comment", "");
  mapping.names_from_comment = options.text("names-from-comment", "");
  read_separators(options, mapping);
  if (mapping.comment.empty() && !mapping.names_from_comment.empty())
    options.error("names-from-comment",
                  "given without `comment`, expected the characters that comment lines start with");
  read_header(options, mapping);
  read_zone(options, mapping);
  read_times(options, mapping);
  for (auto& [id, reader] : options.maps("map")) mapping.devices.push_back(read_device(id, reader, types));
  for (auto& device : mapping.devices) {
    for (auto& column : device.columns) column.form.decimal = mapping.decimal;
    for (auto& property : device.properties) property.form.decimal = mapping.decimal;
  }
  if (mapping.devices.empty()) options.error("map", "missing or empty, expected a map of devices");
  return mapping;
}

std::optional<double> number_of(std::string_view text, char decimal) {
  if (text.starts_with('+')) text.remove_prefix(1);
  std::string with_point;
  if (decimal != '.') {
    if (text.find('.') != text.npos) return std::nullopt;
    with_point = text;
    std::replace(with_point.begin(), with_point.end(), decimal, '.');
    text = with_point;
  }
  const auto number = base::parse_number<double>(text);
  return number && std::isfinite(*number) ? number : std::nullopt;
}

std::string not_a_number(std::string_view text, char decimal) {
  const auto why = fmt::format("`{}`, expected a number", text.substr(0, 40));
  if (decimal == '.') return number_of(text, ',') ? why + "; numbers with a comma need `decimal: \",\"`" : why;
  return number_of(text) ? why + " with the decimal comma that `decimal` names" : why;
}

Result<model::Value> value_of(const CellForm& form, std::string_view cell) {
  const auto word = form.words.empty() ? form.words.end() : form.words.find(std::string(cell));
  const std::string_view text = word == form.words.end() ? cell : std::string_view(word->second);
  const auto data = form.type->data;
  if (data != model::DataType::kReal && data != model::DataType::kInteger)
    return TypeCatalogue::parse_reading(*form.type, text);
  const auto number = number_of(text, form.decimal);
  if (!number) return fail(ErrorCode::kInvalid, not_a_number(text, form.decimal));
  double scaled = *number * form.scale + form.offset;
  if (form.unit) scaled = (*form.unit)(scaled);
  model::Value value = scaled;
  if (data == model::DataType::kInteger && std::abs(scaled) < 9e18)
    value = static_cast<std::int64_t>(std::llround(scaled));
  if (auto fits = TypeCatalogue::check(*form.type, value); !fits) return fail(fits.error());
  return value;
}

bool is_absolute(TimeUnit unit) {
  return unit >= TimeUnit::kUnixSeconds;
}

std::optional<RecordTime> time_of(const CsvMapping& mapping, std::string_view cell,
                                  std::optional<RecordTime> previous) {
  if (mapping.time_unit == TimeUnit::kIso) {
    const auto read = mapping.time_format.empty() ? parse_iso_time(cell) : parse_time(mapping.time_format, cell);
    if (!read) return std::nullopt;
    if (!read->is_local || !mapping.zone) return read->time.time_since_epoch();
    const auto before = previous ? std::optional(WallTime(*previous)) : std::nullopt;
    return mapping.zone->moment_of(read->time, before).time_since_epoch();
  }
  constexpr double kMicroseconds[] = {1, 1e3, 1e6, 60e6, 3600e6, 1e6, 1e3};
  const auto number = number_of(cell, mapping.decimal);
  if (!number) return std::nullopt;
  const double scaled = *number * kMicroseconds[static_cast<std::size_t>(mapping.time_unit)];
  if (std::abs(scaled) > kFurthestMicroseconds) return std::nullopt;
  return RecordTime(std::llround(scaled));
}

}  // namespace rubicon::networks::log
