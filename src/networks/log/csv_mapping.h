#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/config_reader.h"
#include "model/point.h"
#include "model/type_catalogue.h"
#include "model/units.h"
#include "networks/log/file_time.h"
#include "networks/log/replay_clock.h"

namespace rubicon::networks::log {

/// How a cell becomes a value of its type. Text is translated by `words` first; numbers are scaled, then converted to
/// the unit of the type.
struct CellForm {
  const Type* type = nullptr;
  double scale = 1;
  double offset = 0;
  std::optional<model::UnitConversion> unit{};
  std::map<std::string, std::string> words;  ///< spelling in the file -> word of the type
  char decimal = '.';
};

struct ColumnMapping {
  std::string column;  ///< name in the file, or its number counting from 1
  model::Capability capability;
  CellForm form;
};

/// A property of a device that is the same for a whole file: a fixed text, the text of a `name: text` comment line, or
/// the entry of a table for the number in the file's name.
struct PropertyMapping {
  enum class Source { kFixed, kComment, kTable };
  Source source = Source::kFixed;
  std::string text;  ///< the value, the comment's name, or the table's path
  model::Capability capability;
  CellForm form;
};

struct DeviceMapping {
  std::string device;
  std::string name;
  std::string model;
  std::vector<ColumnMapping> columns;
  std::vector<PropertyMapping> properties;
};

/// The unit of the time column. Relative times count from the beginning of the file.
enum class TimeUnit { kMicroseconds, kMilliseconds, kSeconds, kMinutes, kHours, kUnixSeconds, kUnixMilliseconds, kIso };

/// The options of a text table (log.md 2).
struct CsvMapping {
  std::string comment;             ///< lines that start with it hold no data; empty = there are none
  std::size_t header_lines = 1;    ///< the last one holds the column names
  std::string names_from_comment;  ///< or a comment line `<this>: a,b,c` holds them
  std::string separators = ",;\t";
  std::string time_column;  ///< empty = each row is `period` after the one before
  TimeUnit time_unit = TimeUnit::kMilliseconds;
  std::string time_format;       ///< of parse_time(); the unit is kIso then
  std::optional<TimeZone> zone;  ///< of local times; absent = UTC
  char decimal = '.';            ///< of all numbers, also times
  RecordTime period{0};
  std::optional<WallTime> start_time;
  std::vector<DeviceMapping> devices;
};

/// Reads the keys of `format: csv`; mistakes are added to the reader's errors.
CsvMapping read_csv_mapping(ConfigReader& options, const TypeCatalogue& types);

/// The value of a cell; kInvalid or kOutOfRange if its type does not permit it.
Result<model::Value> value_of(const CellForm& form, std::string_view cell);

/// A finite decimal number without blanks, with or without a sign.
std::optional<double> number_of(std::string_view text, char decimal = '.');

/// The time in a cell, in microseconds since the beginning of the file or since 1970. `previous`: the time of the row
/// before; it distinguishes the two times of a repeated hour.
std::optional<RecordTime> time_of(const CsvMapping& mapping, std::string_view cell, std::optional<RecordTime> previous);
bool is_absolute(TimeUnit unit);

}  // namespace rubicon::networks::log
