#include "base/config_reader.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <charconv>
#include <cmath>

#include "base/compare_text.h"

#include "base/text.h"

namespace rubicon::base {

namespace {

const ConfigNode kNoNode;

std::string_view kind_name(ConfigNode::Kind kind) {
  switch (kind) {
    case ConfigNode::Kind::kNull: return "nothing";
    case ConfigNode::Kind::kScalar: return "a value";
    case ConfigNode::Kind::kList: return "a list";
    case ConfigNode::Kind::kMap: return "a map";
  }
  return "something";
}

std::string_view without_plus(std::string_view text) {
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  return text;
}

std::string shown(std::string_view text) {
  return text.size() > 60 ? printable(text.substr(0, 60)) + "..." : printable(text);
}

}  // namespace

void ConfigErrors::add(const ConfigPlace& place, std::string_view path, std::string_view text) {
  auto line = to_string(place);
  if (!line.empty()) line += ": ";
  if (!path.empty()) line += fmt::format("{}: ", path);
  lines_.push_back(line + std::string(text));
}

std::string ConfigErrors::text() const {
  return fmt::format("{}", fmt::join(lines_, "\n"));
}

std::optional<Duration> parse_duration(std::string_view text) {
  const auto unit_at = text.find_first_not_of("0123456789.");
  if (unit_at == 0 || unit_at == text.npos) return std::nullopt;
  const auto amount = parse_number<double>(text.substr(0, unit_at));
  const auto unit = text.substr(unit_at);
  const double seconds = unit == "ms"    ? 1e-3
                         : unit == "us"  ? 1e-6
                         : unit == "s"   ? 1
                         : unit == "min" ? 60
                         : unit == "h"   ? 3600
                         : unit == "d"   ? 86400
                                         : 0;
  if (!amount || seconds == 0 || *amount * seconds > 3.2e9) return std::nullopt;
  return std::chrono::round<Duration>(std::chrono::duration<double>(*amount * seconds));
}

namespace {

struct SizeUnit {
  std::string_view name;
  std::uint64_t bytes;
};
constexpr SizeUnit kSizeUnits[] = {{"TiB", 1ULL << 40},
                                   {"TB", 1'000'000'000'000},
                                   {"GiB", 1ULL << 30},
                                   {"GB", 1'000'000'000},
                                   {"MiB", 1ULL << 20},
                                   {"MB", 1'000'000},
                                   {"KiB", 1ULL << 10},
                                   {"kB", 1000},
                                   {"B", 1}};

}  // namespace

std::optional<std::uint64_t> parse_size(std::string_view text) {
  const auto unit_at = text.find_first_not_of("0123456789.");
  if (unit_at == 0 || unit_at == text.npos) return std::nullopt;
  const auto amount = parse_number<double>(text.substr(0, unit_at));
  for (const auto& unit : kSizeUnits) {
    if (!amount || unit.name != text.substr(unit_at)) continue;
    const double bytes = *amount * static_cast<double>(unit.bytes);
    if (bytes > 9e18) return std::nullopt;
    return static_cast<std::uint64_t>(std::round(bytes));
  }
  return std::nullopt;
}

std::string size_text(std::uint64_t bytes) {
  for (const auto& unit : kSizeUnits) {
    if (bytes >= unit.bytes && bytes % unit.bytes == 0) return fmt::format("{}{}", bytes / unit.bytes, unit.name);
  }
  return "0B";
}

ConfigReader::ConfigReader(const ConfigNode& map, std::string path, ConfigErrors& errors)
    : map_(&map), path_(std::move(path)), errors_(&errors) {
  if (map.kind == ConfigNode::Kind::kMap || map.kind == ConfigNode::Kind::kNull) return;
  errors.add(map.place, path_, fmt::format("is {}, expected a map", kind_name(map.kind)));
  map_ = &kNoNode;
}

std::string ConfigReader::path_of(const std::string& key) const {
  if (key.empty()) return path_;
  return path_.empty() ? key : path_ + "." + key;
}

bool ConfigReader::has(const std::string& key) const {
  return map_->find(key) != nullptr;
}

void ConfigReader::error(const std::string& key, std::string_view text) {
  const auto* node = key.empty() ? nullptr : map_->find(key);
  errors_->add(node ? node->place : map_->place, path_of(key), text);
}

const ConfigNode* ConfigReader::node(const std::string& key) {
  known_.insert(key);
  return map_->find(key);
}

const ConfigNode* ConfigReader::scalar(const std::string& key) {
  const auto* found = node(key);
  if (!found) return nullptr;
  if (found->kind == ConfigNode::Kind::kScalar) return found;
  error(key, fmt::format("is {}, expected one value", kind_name(found->kind)));
  return nullptr;
}

std::string ConfigReader::text(const std::string& key, std::string_view otherwise) {
  const auto* found = scalar(key);
  return found ? found->text : std::string(otherwise);
}

std::string ConfigReader::required_text(const std::string& key, std::string_view expected) {
  if (!has(key)) {
    known_.insert(key);
    errors_->add(map_->place, path_,
                 fmt::format("'{}' is missing{}{}", key, expected.empty() ? "" : ", expected ", expected));
    return {};
  }
  return text(key, {});
}

std::string ConfigReader::choice(const std::string& key, std::string_view otherwise,
                                 std::initializer_list<std::string_view> words) {
  auto chosen = text(key, otherwise);
  for (const auto word : words) {
    if (chosen == word) return chosen;
  }
  if (!has(key)) return std::string(otherwise);
  const auto near = did_you_mean(chosen, {words.begin(), words.end()});
  error(key, fmt::format("is '{}'{} expected one of: {}", shown(chosen), near.empty() ? "," : "; " + near,
                         fmt::join(words, ", ")));
  return std::string(otherwise);
}

bool ConfigReader::boolean(const std::string& key, bool otherwise) {
  const auto* found = scalar(key);
  if (!found) return otherwise;
  if (found->text == "true" || found->text == "yes" || found->text == "on") return true;
  if (found->text == "false" || found->text == "no" || found->text == "off") return false;
  error(key, fmt::format("is '{}', expected yes or no", shown(found->text)));
  return otherwise;
}

std::int64_t ConfigReader::integer(const std::string& key, std::int64_t otherwise, std::int64_t minimum,
                                   std::int64_t maximum) {
  const auto* found = scalar(key);
  if (!found) return otherwise;
  const auto number = parse_number<std::int64_t>(without_plus(found->text));
  if (number && *number >= minimum && *number <= maximum) return *number;
  error(key, fmt::format("is '{}', expected a whole number from {} to {}", shown(found->text), minimum, maximum));
  return otherwise;
}

double ConfigReader::real(const std::string& key, double otherwise, double minimum, double maximum) {
  const auto* found = scalar(key);
  if (!found) return otherwise;
  const auto number = parse_number<double>(without_plus(found->text));
  if (number && std::isfinite(*number) && *number >= minimum && *number <= maximum) return *number;
  error(key, fmt::format("is '{}', expected a number from {} to {}", shown(found->text), minimum, maximum));
  return otherwise;
}

std::optional<Duration> ConfigReader::duration_or_never(const std::string& key, std::optional<Duration> otherwise) {
  const auto* found = scalar(key);
  if (!found) return otherwise;
  if (found->text == "never") return std::nullopt;
  if (const auto duration = parse_duration(found->text)) return duration;
  error(key, fmt::format("is '{}', expected a duration such as 250ms, 5s, 2min, 1h, or never", shown(found->text)));
  return otherwise;
}

Duration ConfigReader::duration(const std::string& key, Duration otherwise) {
  const auto* found = scalar(key);
  if (!found) return otherwise;
  if (const auto duration = parse_duration(found->text)) return *duration;
  error(key, fmt::format("is '{}', expected a duration such as 250ms, 5s, 2min, 1h", shown(found->text)));
  return otherwise;
}

std::uint64_t ConfigReader::size(const std::string& key, std::uint64_t otherwise, std::uint64_t minimum,
                                 std::uint64_t maximum) {
  const auto* found = scalar(key);
  if (!found) return otherwise;
  const auto size = parse_size(found->text);
  if (!size) {
    error(key, fmt::format("is '{}', expected a size such as 500kB, 64KiB, 100MB, 1GB", shown(found->text)));
    return otherwise;
  }
  if (*size >= minimum && *size <= maximum) return *size;
  error(key,
        fmt::format("is '{}', expected from {} to {}", shown(found->text), size_text(minimum), size_text(maximum)));
  return otherwise;
}

ConfigReader ConfigReader::map(const std::string& key) {
  const auto* found = node(key);
  return ConfigReader(found ? *found : kNoNode, path_of(key), *errors_);
}

std::vector<std::pair<std::string, ConfigReader>> ConfigReader::maps(const std::string& key) {
  std::vector<std::pair<std::string, ConfigReader>> readers;
  const auto nested = map(key);
  for (const auto& [name, entry] : nested.here().entries) {
    readers.emplace_back(name, ConfigReader(entry, nested.path_of(name), *errors_));
  }
  return readers;
}

std::vector<std::string> ConfigReader::texts(const std::string& key) {
  const auto* found = node(key);
  std::vector<std::string> out;
  if (!found) return out;
  if (found->kind == ConfigNode::Kind::kScalar) return {found->text};
  if (found->kind != ConfigNode::Kind::kList) {
    error(key, fmt::format("is {}, expected a list of values", kind_name(found->kind)));
    return out;
  }
  for (const auto& item : found->items) {
    if (item.kind == ConfigNode::Kind::kScalar) {
      out.push_back(item.text);
    } else {
      errors_->add(item.place, path_of(key), fmt::format("contains {}, expected only values", kind_name(item.kind)));
    }
  }
  return out;
}

std::vector<ConfigReader> ConfigReader::list(const std::string& key) {
  const auto* found = node(key);
  std::vector<ConfigReader> readers;
  if (!found) return readers;
  if (found->kind != ConfigNode::Kind::kList) {
    error(key, fmt::format("is {}, expected a list", kind_name(found->kind)));
    return readers;
  }
  for (std::size_t i = 0; i < found->items.size(); ++i) {
    readers.emplace_back(found->items[i], fmt::format("{}[{}]", path_of(key), i), *errors_);
  }
  return readers;
}

std::vector<std::string> ConfigReader::keys() const {
  std::vector<std::string> names;
  for (const auto& entry : map_->entries) names.push_back(entry.first);
  return names;
}

void ConfigReader::also_known(std::span<const std::string_view> keys) {
  for (const auto key : keys) known_.emplace(key);
}

void ConfigReader::finish() {
  const std::vector<std::string> known(known_.begin(), known_.end());
  for (const auto& [name, entry] : map_->entries) {
    if (known_.contains(name)) continue;
    const auto near = did_you_mean(name, known);
    errors_->add(entry.key_place(), path_,
                 fmt::format("unknown key '{}'{} known: {}", shown(name), near.empty() ? "," : "; " + near,
                             fmt::join(known, ", ")));
  }
}

}  // namespace rubicon::base
