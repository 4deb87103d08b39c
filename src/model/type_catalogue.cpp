#include "model/type_catalogue.h"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <unordered_map>
#include <vector>

#include "base/assert.h"
#include "base/compare_text.h"
#include "model/type_names.h"
#include "model/type_tables.h"
#include "rubicon/key.hpp"

namespace rubicon::model {

namespace {

/// The released firmware has no duty cycle and no threshold, and its mask follows the subscribers (docs/motes.md).
constexpr PropertyOfDevice kMoteProperties[] = {{"rate", Access::kReadWrite, ""}, {"mask", Access::kRead, ""}};
constexpr PropertyOfDevice kRecordedProperties[] = {
    {"activityLabel", Access::kRead, ""}, {"label", Access::kRead, ""}, {"group", Access::kRead, ""}};
constexpr PropertyOfDevice kSimulatedProperties[] = {{"rate", Access::kReadWrite, ""}};
constexpr PropertyOfDevice kLampProperties[] = {{"transitionTime", Access::kReadWrite, "dimmer"},
                                                {"powerOnBehaviour", Access::kReadWrite, "lamp"}};
constexpr PropertyOfDevice kDetectorProperties[] = {{"sensitivity", Access::kReadWrite, "motion"},
                                                    {"interval", Access::kReadWrite, ""}};
constexpr DeviceType kDeviceTypes[] = {{1, "mote", kMoteProperties},
                                       {2, "recorded", kRecordedProperties},
                                       {3, "simulated", kSimulatedProperties},
                                       {4, "lamp", kLampProperties},
                                       {5, "detector", kDetectorProperties}};

bool is_type_name(std::string_view name) {
  const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  if (name.empty() || name.size() > 64 || !letter(name[0])) return false;
  return std::all_of(name.begin(), name.end(),
                     [letter](char c) { return letter(c) || (c >= '0' && c <= '9') || c == '_'; });
}

}  // namespace

struct TypeCatalogue::Content {
  std::deque<SiteType> owned;  ///< the text that site types point into
  std::deque<Type> site;
  std::vector<const Type*> all;
  std::unordered_map<std::string_view, const Type*> by_name;
  std::unordered_map<std::uint16_t, const Type*> by_id;

  void add(const Type& type) {
    RUBICON_ASSERT(by_name.emplace(type.name, &type).second);
    RUBICON_ASSERT(by_id.emplace(static_cast<std::uint16_t>(type.id), &type).second);
    all.push_back(&type);
  }
};

TypeCatalogue::TypeCatalogue() : content_(std::make_unique<Content>()) {
  for (const auto table : {mote_types(), register_types(), home_types(), quantity_types(), property_types()}) {
    for (const auto& type : table) content_->add(type);
  }
}
TypeCatalogue::~TypeCatalogue() = default;
TypeCatalogue::TypeCatalogue(TypeCatalogue&&) noexcept = default;
TypeCatalogue& TypeCatalogue::operator=(TypeCatalogue&&) noexcept = default;

const Type* TypeCatalogue::find(TypeId id) const {
  const auto found = content_->by_id.find(static_cast<std::uint16_t>(id));
  if (found != content_->by_id.end()) [[likely]]
    return found->second;
  const auto now = current_type(id);
  return now == id ? nullptr : find(now);
}

const Type* TypeCatalogue::find(std::string_view name) const {
  const auto found = content_->by_name.find(name);
  if (found != content_->by_name.end()) return found->second;
  const auto now = current_type(name);
  return now == name ? nullptr : find(now);
}

std::span<const Type* const> TypeCatalogue::all() const {
  return content_->all;
}

std::span<const DeviceType> TypeCatalogue::device_types() {
  return kDeviceTypes;
}

Result<void> TypeCatalogue::declare(const SiteType& type) {
  if (!is_type_name(type.name)) {
    return fail(ErrorCode::kInvalid, fmt::format("type name {}: expected a letter, then at most 63 of [A-Za-z0-9_]",
                                                 model::quoted(type.name)));
  }
  if (type.id < kFirstSiteType) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("type {}: id {:#06x} is not the site's own, expected 0x8000..0xffff", type.name, type.id));
  }
  if (const auto* taken = find(type.name)) {
    return fail(ErrorCode::kDuplicate, fmt::format("type {}: the name is taken by id {:#06x}", type.name,
                                                   static_cast<std::uint16_t>(taken->id)));
  }
  if (const auto* taken = find(TypeId(type.id))) {
    return fail(ErrorCode::kDuplicate,
                fmt::format("type {}: id {:#06x} is taken by {}", type.name, type.id, taken->name));
  }
  if (!(type.minimum <= type.maximum)) {
    return fail(ErrorCode::kInvalid, fmt::format("type {}: the minimum is above the maximum", type.name));
  }
  if (type.data == DataType::kEnumeration && type.words.empty()) {
    return fail(ErrorCode::kInvalid, fmt::format("type {}: an enumeration needs its words", type.name));
  }
  const auto& text = content_->owned.emplace_back(type);
  content_->add(content_->site.emplace_back(Type{TypeId(text.id), text.name, text.quantity, text.unit, text.data,
                                                 text.minimum, text.maximum, text.report, text.words}));
  return {};
}

std::string_view to_string(DataType type) {
  switch (type) {
    case DataType::kBoolean: return "boolean";
    case DataType::kInteger: return "integer";
    case DataType::kReal: return "real";
    case DataType::kEnumeration: return "enumeration";
    case DataType::kText: return "text";
    case DataType::kJson: return "json";
    case DataType::kBytes: return "bytes";
  }
  return "unknown";
}

std::optional<DataType> parse_data_type(std::string_view word) {
  for (int i = 0; i <= static_cast<int>(DataType::kBytes); ++i) {
    if (to_string(static_cast<DataType>(i)) == word) return static_cast<DataType>(i);
  }
  return std::nullopt;
}

std::string_view to_string(Kind kind) {
  switch (kind) {
    case Kind::kSensor: return "sensor";
    case Kind::kActuator: return "actuator";
    case Kind::kProperty: return "property";
  }
  return "unknown";
}

std::optional<Kind> parse_kind(std::string_view word) {
  for (const auto kind : {Kind::kSensor, Kind::kActuator, Kind::kProperty}) {
    if (to_string(kind) == word) return kind;
  }
  return std::nullopt;
}

std::string_view to_string(Access access) {
  switch (access) {
    case Access::kRead: return "read";
    case Access::kWrite: return "write";
    case Access::kReadWrite: return "read-write";
  }
  return "unknown";
}

TypeId open_type(std::string_view name) {
  std::uint32_t hash = 0x811c9dc5;  // FNV-1a
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 0x01000193;
  return TypeId(kFirstOpenType + (hash ^ (hash >> 16)) % (kFirstSiteType - kFirstOpenType));
}

std::string unknown_type_text(const TypeCatalogue& types, std::string_view name) {
  std::vector<std::string> names;
  for (const auto* type : types.all()) names.emplace_back(type->name);
  const auto near = base::did_you_mean(name, names);
  return fmt::format("unknown type '{}'{} expected one that `rubicon types` lists, or one declared in `types`", name,
                     near.empty() ? "," : "; " + near);
}

}  // namespace rubicon::model
