#include "motes/learning_records.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <utility>

#include "base/text.h"

namespace rubicon::motes {

namespace {

using enum FieldKind;
using Field = RecordField;

// The layouts of wsn.md 7.2: name, kind, offset, count, counted by, fixed value.
constexpr Field kCommand[] = {{"command", kU8, 0}, {"counter", kU16, 1}, {"delay", kU16, 3}};
constexpr Field kSerialData[] = {{"island", kU8, 0}, {"mote", kU16, 1},  {"counter", kU16, 3}, {"temp", kU16, 5},
                                 {"humid", kU16, 7}, {"light", kU16, 9}, {"rssi", kU16, 11}};
constexpr Field kNetIdCmd[] = {{"command", kU8, 0}, {"netId", kU16, 1}, {"seq", kU16, 3}};
constexpr Field kBroadcastCmd[] = {{"type", kU8, 0}, {"clock", kU16, 1}, {"seq", kU16, 3}};
constexpr Field kSynCreateCmd[] = {{"type", kU8, 0},
                                   {"srcIsland", kU16, 1},
                                   {"srcMote", kU16, 3},
                                   {"destIsland", kU16, 5},
                                   {"destMote", kU16, 7},
                                   {"srcNetId", kU16, 9},
                                   {"destNetId", kU16, 11},
                                   {"srcCount", kU8, 13},
                                   {"srcNeurons", kU16, 14, 10, "srcCount"},
                                   {"destCount", kU8, 34},
                                   {"destNeurons", kU16, 35, 10, "destCount"},
                                   {"params", kI8, 55},
                                   {"seq", kU16, 56}};
constexpr Field kLearningModuleCmd[] = {{"type", kU8, 0}, {"netId", kU16, 1}, {"seq", kU16, 3},       {"rows", kU8, 5},
                                        {"cols", kU8, 6}, {"size", kU8, 7},   {"weights", kU8, 8, 92}};
constexpr Field kLearningModuleFloatCmd[] = {{"type", kU8, 0},         {"netId", kU16, 1}, {"seq", kU16, 3},
                                             {"rows", kU8, 5},         {"cols", kU8, 6},   {"size", kU8, 7},
                                             {"floats", kFloat, 8, 23}};
constexpr Field kLearningModuleDown[] = {
    {"type", kU8, 0, 1, {}, 0x18}, {"netId", kU16, 1}, {"size", kU8, 3}, {"floats", kFloat, 4, 23}};
constexpr Field kLearningOutput[] = {
    {"type", kU8, 0, 1, {}, 0x19}, {"count", kU8, 1}, {"floats", kFloat, 2, 24, "count"}};
constexpr Field kComplete[] = {{"destIsland", kU16, 0}, {"destMote", kU16, 2}, {"srcIsland", kU16, 4},
                               {"srcMote", kU16, 6},    {"reliable", kU8, 8},  {"seq", kU16, 9},
                               {"nbytes", kU8, 11},     {"transId", kU8, 12},  {"appId", kU8, 13},
                               {"type", kU8, 14},       {"mask", kU16, 15},    {"period", kU16, 17}};
constexpr Field kConnless[] = {{"type", kU8, 0}, {"island", kU8, 1}, {"mote", kU16, 2},       {"reliable", kU8, 4},
                               {"seq", kU16, 5}, {"nbytes", kU8, 7}, {"payload", kU8, 8, 100}};
constexpr Field kRAddr[] = {{"pid", kU16, 0}, {"devid", kU16, 2}};
// Ten floats a channel (wsn.md 9.10, 12); that nothing precedes them is unverified.
constexpr Field kSynData[] = {{"floats", kFloat, 0, 10}};

constexpr std::uint8_t kT = kTransportConnectionless, kA = kApplicationLearning;  // wsn.md 6
constexpr LearningRecord kRecords[] = {
    {"Command", 0x0b, 0, 0, 5, kCommand, true},
    {"SerialData", 0x0c, 0, 0, 13, kSerialData, true},
    {"SynData", 0x0d, kTransportSynaptic, kApplicationSynaptic, 40, kSynData},
    {"NetIdCmd", 0x11, kT, kA, 5, kNetIdCmd},
    {"BroadcastCmd", 0x12, kT, kA, 5, kBroadcastCmd},
    {"SynCreateCmd", 0x13, kT, kA, 58, kSynCreateCmd},
    {"LearningModuleCmd", 0x14, kT, kA, 100, kLearningModuleCmd},
    {"LearningModuleFloatCmd", 0x15, kT, kA, 100, kLearningModuleFloatCmd},
    {"LearningModuleDown", 0x18, kT, kA, 96, kLearningModuleDown},
    {"LearningOutput", 0x19, kT, kA, 98, kLearningOutput},
    {"Connless", 0x1b, 0, 0, 108, kConnless},
    {"RAddr", 0x1f, 0, 0, 4, kRAddr},
    {"Complete", 0x21, 0, 0, 19, kComplete},
};

struct KindTraits {
  std::size_t size;
  double least, most;
};

KindTraits traits_of(FieldKind kind) {
  switch (kind) {
    case kU8: return {1, 0, 0xff};
    case kI8: return {1, -128, 127};
    case kU16: return {2, 0, 0xffff};
    case kFloat: break;
  }
  constexpr double kMax = std::numeric_limits<float>::max();
  return {4, -kMax, kMax};
}

template <typename... Arguments>
auto wrong(ErrorCode code, const LearningRecord& record, fmt::format_string<Arguments...> text,
           Arguments&&... arguments) {
  return fail(code,
              fmt::format("mote record {}: {}", record.name, fmt::format(text, std::forward<Arguments>(arguments)...)));
}

/// The array that `field` counts; nullptr if it counts none.
const RecordField* counted_by(const LearningRecord& record, const RecordField& field) {
  const auto found = std::ranges::find(record.fields, field.name, &RecordField::counted_by);
  return found != record.fields.end() ? &*found : nullptr;
}

/// A name from outside, shortened and made printable.
std::string shown(std::string_view name) {
  constexpr std::size_t kShown = 40;
  return base::printable(name.substr(0, kShown));
}

Result<void> check_names(const LearningRecord& record, const FieldValues& values) {
  for (const auto& [name, numbers] : values) {
    if (record.find(name) != nullptr) continue;
    std::string known;
    for (const RecordField& field : record.fields) known += fmt::format("{}{}", known.empty() ? "" : ", ", field.name);
    return wrong(ErrorCode::kInvalid, record, "unknown field \"{}\", expected {}", shown(name), known);
  }
  return {};
}

Result<void> check_range(const LearningRecord& record, const RecordField& field, double number) {
  const KindTraits traits = traits_of(field.kind);
  const bool inside = number >= traits.least && number <= traits.most;
  if (inside && (field.kind == kFloat || number == std::floor(number))) return {};
  return wrong(ErrorCode::kOutOfRange, record, "{} is {}, expected {} from {} to {}", field.name, number,
               field.kind == kFloat ? "a number" : "a whole number", traits.least, traits.most);
}

/// Checks how many numbers were given for a field.
Result<void> check_count(const LearningRecord& record, const RecordField& field, std::size_t given) {
  if (field.is_array() && given > field.count)
    return wrong(ErrorCode::kOutOfRange, record, "{} has {} elements, expected at most {}", field.name, given,
                 field.count);
  if (!field.is_array() && given != 1)
    return wrong(ErrorCode::kInvalid, record, "{} has {} elements, expected one number", field.name, given);
  return {};
}

/// The numbers to write for a field: those given, or the defaults of an omitted one.
Result<std::vector<double>> numbers_for(const LearningRecord& record, const RecordField& field,
                                        const FieldValues& values) {
  const auto given = values.find(field.name);
  std::optional<double> count;
  if (const RecordField* array = counted_by(record, field)) {
    const auto elements = values.find(array->name);
    count = elements != values.end() ? static_cast<double>(elements->second.size()) : 0;
  }
  if (given == values.end()) {
    if (count) return std::vector<double>{*count};
    if (field.fixed >= 0) return std::vector<double>{static_cast<double>(field.fixed)};
    if (field.is_array()) return std::vector<double>{};
    const KindTraits traits = traits_of(field.kind);
    return wrong(ErrorCode::kInvalid, record, "{} is missing, expected a number from {} to {}", field.name,
                 traits.least, traits.most);
  }
  if (auto fits = check_count(record, field, given->second.size()); !fits) return fail(fits.error());
  if (field.fixed >= 0 && given->second.front() != field.fixed)
    return wrong(ErrorCode::kInvalid, record, "{} is {}, expected {}", field.name, given->second.front(), field.fixed);
  if (count && given->second.front() != *count)
    return wrong(ErrorCode::kInvalid, record, "{} is {}, expected {}, the number of elements", field.name,
                 given->second.front(), *count);
  return given->second;
}

void put(FieldKind kind, double number, std::uint8_t* at) {
  if (kind == kFloat) {
    const auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(number));
    for (unsigned i = 0; i < 4; ++i) at[i] = static_cast<std::uint8_t>(bits >> (8 * i));
  } else if (kind == kU16) {
    const auto whole = static_cast<std::uint16_t>(number);
    at[0] = static_cast<std::uint8_t>(whole >> 8);
    at[1] = static_cast<std::uint8_t>(whole);
  } else {
    at[0] = static_cast<std::uint8_t>(static_cast<std::int16_t>(number));
  }
}

double get(FieldKind kind, base::ByteReader& reader) {
  switch (kind) {
    case kU8: return reader.u8();
    case kI8: return static_cast<std::int8_t>(reader.u8());
    case kU16: return reader.u16_be();
    case kFloat: break;
  }
  return std::bit_cast<float>(reader.u32_le());
}

/// The number of elements of a field in the record. `read`: the preceding fields.
Result<std::size_t> numbers_in(const LearningRecord& record, const RecordField& field, ByteView bytes,
                               const FieldValues& read) {
  const std::size_t size = traits_of(field.kind).size;
  const std::size_t there = bytes.size() > field.offset ? (bytes.size() - field.offset) / size : 0;
  if (field.is_array() && field.counted_by.empty()) return std::min(there, field.count);
  std::size_t count = 1;
  if (field.is_array()) count = static_cast<std::size_t>(read.find(field.counted_by)->second.front());
  if (count > field.count)
    return wrong(ErrorCode::kInvalid, record, "{} is {}, expected at most {}", field.counted_by, count, field.count);
  if (count > there)
    return wrong(ErrorCode::kInvalid, record, "cut short in {} after {} bytes, expected {}", field.name, bytes.size(),
                 record.size);
  return count;
}

/// The form of a command to a mote, by the learning command in its first byte (wsn.md 6).
std::uint8_t form_of_command(std::uint8_t command) {
  constexpr std::uint8_t kNetId = 0x11, kBroadcast = 0x12, kSynCreate = 0x13, kMatrix = 0x14;
  switch (command) {
    case 8: return kBroadcast;
    case 9:
    case 10:
    case 11: return kSynCreate;
    case 12:
    case 16:
    case 18:
    case 20:
    case 22:
    case 28: return kMatrix;
    default: return command >= 1 && command <= 27 ? kNetId : 0;
  }
}

}  // namespace

const RecordField* LearningRecord::find(std::string_view field) const {
  const auto found = std::ranges::find(fields, field, &RecordField::name);
  return found != fields.end() ? &*found : nullptr;
}

std::span<const LearningRecord> learning_records() {
  return kRecords;
}

const LearningRecord* find_learning_record(std::string_view name) {
  constexpr std::string_view kEnding = "Msg";
  if (name.ends_with(kEnding)) name.remove_suffix(kEnding.size());
  const auto* found = std::ranges::find(kRecords, name, &LearningRecord::name);
  return found != std::end(kRecords) ? found : nullptr;
}

const LearningRecord* find_learning_record(std::uint8_t type) {
  const auto* found = std::ranges::find(kRecords, type, &LearningRecord::type);
  return found != std::end(kRecords) ? found : nullptr;
}

const LearningRecord* learning_record_in(const NetMessage& message) {
  constexpr std::uint8_t kSynDataType = 0x0d, kDownType = 0x18, kOutputType = 0x19;
  if (message.transport == kTransportSynaptic && message.application == kApplicationSynaptic)
    return find_learning_record(kSynDataType);
  if (message.transport != kTransportConnectionless || message.application != kApplicationLearning ||
      message.record.empty())
    return nullptr;
  const std::uint8_t first = message.record.front();
  // Messages to the computer begin with their record type, messages to a mote with a learning command.
  if (message.destination_mote == kBaseMote)
    return first == kDownType || first == kOutputType ? find_learning_record(first) : nullptr;
  return find_learning_record(form_of_command(first));
}

Result<Bytes> encode_learning(std::string_view name, const FieldValues& values) {
  const LearningRecord* record = find_learning_record(name);
  if (record == nullptr) return fail(ErrorCode::kNotFound, fmt::format("unknown mote record \"{}\"", shown(name)));
  if (auto known = check_names(*record, values); !known) return fail(known.error());
  Bytes out(record->size);
  for (const RecordField& field : record->fields) {
    const auto numbers = numbers_for(*record, field, values);
    if (!numbers) return fail(numbers.error());
    std::uint8_t* at = out.data() + field.offset;
    for (const double number : *numbers) {
      if (auto fits = check_range(*record, field, number); !fits) return fail(fits.error());
      put(field.kind, number, at);
      at += traits_of(field.kind).size;
    }
  }
  return out;
}

Result<FieldValues> decode_learning(const LearningRecord& record, ByteView bytes) {
  FieldValues values;
  for (const RecordField& field : record.fields) {
    const auto count = numbers_in(record, field, bytes, values);
    if (!count) return fail(count.error());
    base::ByteReader reader(bytes.subspan(std::min(field.offset, bytes.size())));
    std::vector<double>& numbers = values[std::string(field.name)];
    for (std::size_t i = 0; i < *count; ++i) numbers.push_back(get(field.kind, reader));
    if (field.fixed >= 0 && numbers.front() != field.fixed)
      return wrong(ErrorCode::kInvalid, record, "{} is {}, expected {}", field.name, numbers.front(), field.fixed);
  }
  return values;
}

Result<FieldValues> decode_learning(std::uint8_t type, ByteView bytes) {
  const LearningRecord* record = find_learning_record(type);
  if (record == nullptr) return fail(ErrorCode::kNotFound, fmt::format("unknown mote record type {}", type));
  return decode_learning(*record, bytes);
}

std::vector<ByteView> matrix_chunks(ByteView matrix) {
  std::vector<ByteView> chunks;
  for (std::size_t chunk = 0; chunk < matrix.size() / kMatrixChunk + 1; ++chunk) {
    const std::size_t at = chunk * kMatrixChunk;
    chunks.push_back(matrix.subspan(at, std::min(kMatrixChunk, matrix.size() - at)));
  }
  return chunks;
}

}  // namespace rubicon::motes
