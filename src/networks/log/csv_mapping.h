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
#include "networks/log/replay_clock.h"

namespace rubicon::networks::log {

/// A cell as a value of its type: text through `words`, then by the type; numbers through scale and offset, then into
/// the unit of the type.
struct CellForm {
  const Type* type = nullptr;
  double scale = 1;
  double offset = 0;
  std::optional<model::UnitConversion> unit{};
  std::map<std::string, std::string> words;  ///< spelling in the file -> word of the type
};

struct ColumnMapping {
  std::string column;  ///< name in the file, or its number counting from 1
  model::Capability capability;
  CellForm form;
};

/// A property of a device that holds for a whole file: a fixed text, a `name: text` comment line, or what a side table
/// says about the number in the file's name.
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

/// How the time of a row is written. Relative units count from the beginning of the file.
enum class TimeUnit { kMicroseconds, kMilliseconds, kSeconds, kMinutes, kHours, kUnixSeconds, kUnixMilliseconds, kIso };

/// Everything the configuration says about a text table (log.md 2).
struct CsvMapping {
  std::string comment;             ///< lines that start so hold no data; empty = there are none
  std::size_t header_lines = 1;    ///< the last of them holds the column names
  std::string names_from_comment;  ///< comment line `<this>: a,b,c` that holds the names instead
  std::string separators = ",;\t";
  std::string time_column;  ///< empty = every row comes `period` after the one before
  TimeUnit time_unit = TimeUnit::kMilliseconds;
  RecordTime period{0};
  std::optional<WallTime> start_time;
  std::vector<DeviceMapping> devices;
};

/// Reads the keys of `format: csv`; what is wrong stands in the reader's errors.
CsvMapping read_csv_mapping(ConfigReader& options, const TypeCatalogue& types);

/// The value of a cell; kInvalid or kOutOfRange for what its type does not permit.
Result<model::Value> value_of(const CellForm& form, std::string_view cell);

/// A decimal number without blanks; nothing for NaN, infinities and text.
std::optional<double> number_of(std::string_view text);

/// The time in a cell, as microseconds since the file's beginning or since 1970.
std::optional<RecordTime> time_of(TimeUnit unit, std::string_view cell);
bool is_absolute(TimeUnit unit);

}  // namespace rubicon::networks::log
