#include "networks/log/foreign_recordings.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/text.h"

namespace rubicon::networks::log {

CsvRecording::CsvRecording(CsvMapping mapping, ReplayCounters& counters, Complaint complain)
    : mapping_(std::move(mapping)), counters_(counters), complain_(std::move(complain)) {}

void CsvRecording::begin(std::string_view, std::vector<std::string> labels) {
  reader_ = LineReader();
  columns_.assign(mapping_.devices.size(), {});
  labels_ = std::move(labels);
  comments_.clear();
  time_cell_.reset();
  header_left_ = mapping_.header_lines;
  row_number_ = 0;
  previous_.reset();
  names_known_ = false;
  described_ = false;
}

bool CsvRecording::absolute_times() const {
  return !mapping_.time_column.empty() && is_absolute(mapping_.time_unit);
}

std::vector<std::string> CsvRecording::label_tables() const {
  std::vector<std::string> tables;
  for (const DeviceMapping& device : mapping_.devices) {
    for (const PropertyMapping& property : device.properties) {
      if (property.source == PropertyMapping::Source::kTable) tables.push_back(property.text);
    }
  }
  return tables;
}

std::vector<std::string> CsvRecording::devices() const {
  std::vector<std::string> devices;
  for (const DeviceMapping& device : mapping_.devices) devices.push_back(device.device);
  return devices;
}

std::optional<Step> CsvRecording::next() {
  while (auto line = reader_.next()) {
    if (auto step = on_line(*line)) return step;
  }
  return std::nullopt;
}

std::optional<Step> CsvRecording::on_line(const TextLine& line) {
  ++counters_.lines;
  if (line.too_long) {
    counters_.skipped_bytes += line.bytes;
    return damaged(line, fmt::format("line {} has {} bytes, expected at most {}", line.number, line.bytes, kMaxLine));
  }
  const std::string_view text = base::trimmed(line.text);
  if (text.empty() || on_comment(text)) return std::nullopt;
  if (header_left_ > 0) {
    if (--header_left_ == 0 && mapping_.names_from_comment.empty()) on_names(line.text, line.offset);
    return std::nullopt;
  }
  if (!names_known_) on_names("", line.offset);
  return row(line);
}

bool CsvRecording::on_comment(std::string_view text) {
  if (mapping_.comment.empty() || !text.starts_with(mapping_.comment)) return false;
  text = base::trimmed(text.substr(mapping_.comment.size()));
  const std::size_t colon = text.find(':');
  if (colon == std::string_view::npos) return true;
  const std::string name(base::trimmed(text.substr(0, colon)));
  const std::string_view value = base::trimmed(text.substr(colon + 1));
  if (!mapping_.names_from_comment.empty() && name == mapping_.names_from_comment) {
    on_names(value, 0);
  } else if (comments_.size() < 100) {
    comments_[name] = value;
  }
  return true;
}

void CsvRecording::on_names(std::string_view text, std::uint64_t offset) {
  // Some copies of public data sets begin the header with a comment sign (log.md 2.2).
  text = base::trimmed(text);
  if (text.starts_with('#')) text.remove_prefix(1);
  split_cells(text, mapping_.separators, cells_);
  find_columns({cells_.begin(), cells_.end()}, offset);
  names_known_ = true;
}

void CsvRecording::find_columns(const std::vector<std::string>& names, std::uint64_t offset) {
  const auto cell_of = [&names](const std::string& column) -> std::optional<std::size_t> {
    const auto found = std::find(names.begin(), names.end(), column);
    if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
    const auto number = number_of(column);
    if (number && *number >= 1 && *number <= static_cast<double>(kMaxLine))
      return static_cast<std::size_t>(*number) - 1;
    return std::nullopt;
  };
  if (!mapping_.time_column.empty()) {
    time_cell_ = cell_of(mapping_.time_column);
    if (!time_cell_) complain_(offset, fmt::format("no time column `{}`", mapping_.time_column));
  }
  for (std::size_t d = 0; d < mapping_.devices.size(); ++d) {
    columns_[d].clear();
    for (const ColumnMapping& column : mapping_.devices[d].columns) {
      const auto cell = cell_of(column.column);
      if (cell)
        columns_[d].push_back({*cell, &column});
      else
        complain_(offset, fmt::format("no column `{}`", column.column));
    }
  }
}

std::optional<Step> CsvRecording::damaged(const TextLine& line, std::string_view what) {
  ++counters_.damaged;
  complain_(line.offset, what);
  return std::nullopt;
}

std::optional<RecordTime> CsvRecording::row_time() {
  if (mapping_.time_column.empty()) return mapping_.period * static_cast<RecordTime::rep>(row_number_);
  if (!time_cell_ || *time_cell_ >= cells_.size()) return std::nullopt;
  const auto time = time_of(mapping_, cells_[*time_cell_], previous_);
  if (time) previous_ = time;
  return time;
}

std::optional<Step> CsvRecording::row(const TextLine& line) {
  split_cells(line.text, mapping_.separators, cells_);
  const auto time = row_time();
  if (!time) return damaged(line, fmt::format("line {} has no readable time", line.number));
  ++row_number_;
  Step step;
  step.time = *time;
  if (absolute_times())
    step.wall = WallTime(*time);
  else if (mapping_.start_time)
    step.wall = *mapping_.start_time + *time;
  if (!described_) add_joins_and_properties(step);
  for (std::size_t device = 0; device < columns_.size(); ++device) read_cells(line, device, step);
  ++counters_.records;
  return step;
}

void CsvRecording::read_cells(const TextLine& line, std::size_t device, Step& step) {
  model::Updates updates;
  for (const FoundColumn& column : columns_[device]) {
    if (column.cell >= cells_.size()) {
      damaged(line,
              fmt::format("line {} has {} cells, expected at least {}", line.number, cells_.size(), column.cell + 1));
      continue;
    }
    const std::string_view cell = cells_[column.cell];
    if (cell.empty()) continue;
    auto value = value_of(column.mapping->form, cell);
    if (value) {
      updates.readings.push_back({column.mapping->capability.point, std::move(*value), {}});
    } else {
      damaged(line, fmt::format("line {}, column `{}`: {}", line.number, column.mapping->column, value.error().text));
    }
  }
  if (!updates.readings.empty()) step.messages.emplace_back(mapping_.devices[device].device, std::move(updates));
}

void CsvRecording::add_joins_and_properties(Step& step) {
  described_ = true;
  std::size_t label = 0;
  for (const DeviceMapping& device : mapping_.devices) {
    if (!joined_) step.messages.emplace_back(device.device, join_of(device));
    model::Updates properties = properties_of(device, label);
    if (!properties.readings.empty()) step.messages.emplace_back(device.device, std::move(properties));
  }
  joined_ = true;
}

model::Join CsvRecording::join_of(const DeviceMapping& device) const {
  model::Join join;
  join.name = device.name;
  join.model = device.model;
  for (const ColumnMapping& column : device.columns) join.capabilities.push_back(column.capability);
  for (const PropertyMapping& property : device.properties) join.capabilities.push_back(property.capability);
  return join;
}

model::Updates CsvRecording::properties_of(const DeviceMapping& device, std::size_t& label) {
  model::Updates updates;
  for (const PropertyMapping& property : device.properties) {
    std::string text = property.text;
    if (property.source == PropertyMapping::Source::kComment) text = comments_[property.text];
    if (property.source == PropertyMapping::Source::kTable) text = label < labels_.size() ? labels_[label++] : "";
    if (text.empty()) continue;
    auto value = value_of(property.form, text);
    if (value)
      updates.readings.push_back({property.capability.point, std::move(*value), {}});
    else
      complain_(0, fmt::format("property `{}`: {}", property.capability.type_name, value.error().text));
  }
  return updates;
}

namespace {

/// Keeps a damaged timestamp within the range of microseconds; the replay clock limits it further.
RecordTime time_of(std::chrono::milliseconds written) {
  constexpr std::chrono::milliseconds kFurthest(4'000'000'000'000'000);
  return std::clamp(written, -kFurthest, kFurthest);
}

}  // namespace

PacketRecording::PacketRecording(const TypeCatalogue& types, motes::Calibration calibration, ReplayCounters& counters,
                                 Complaint complain)
    : codec_(types, {calibration}), counters_(counters), complain_(std::move(complain)) {}

void PacketRecording::begin(std::string_view, std::vector<std::string>) {
  reader_ = motes::PacketLogReader();
}

std::optional<Step> PacketRecording::next() {
  while (auto item = reader_.next()) {
    if (const auto* damage = std::get_if<motes::Damage>(&*item)) {
      ++counters_.damaged;
      counters_.skipped_bytes += damage->bytes;
      complain_(damage->offset, fmt::format("{}; {} bytes skipped", damage->why, damage->bytes));
      continue;
    }
    const auto& record = std::get<motes::PacketRecord>(*item);
    if (!record.from_sink) continue;
    if (auto step = step_of(record)) return step;
  }
  return std::nullopt;
}

std::optional<Step> PacketRecording::step_of(const motes::PacketRecord& record) {
  auto events = codec_.decode(record.packet);
  if (!events) {
    ++counters_.damaged;
    complain_(record.offset, events.error().text);
    return std::nullopt;
  }
  ++counters_.records;
  Step step;
  step.time = time_of(record.time);
  step.wall = WallTime(step.time);
  for (model::Message& message : events->messages) {
    if (!message.source.device.empty()) devices_.insert(message.source.device);
    step.messages.emplace_back(std::move(message.source.device), std::move(message.body));
  }
  return step;
}

}  // namespace rubicon::networks::log
