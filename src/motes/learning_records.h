#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/bytes.h"
#include "motes/mote_packet.h"

namespace rubicon::motes {

/// How a number stands in a record (wsn.md 7.2): integers big-endian, floats IEEE 754 single, little-endian.
enum class FieldKind : std::uint8_t { kU8, kI8, kU16, kFloat };

/// Where a field stands in its record, and what goes into it.
struct RecordField {
  std::string_view name;
  FieldKind kind = FieldKind::kU8;
  std::size_t offset = 0;
  std::size_t count = 1;             ///< 1: a number; more: an array of at most so many
  std::string_view counted_by = {};  ///< the field before it that says how many of the array count; empty: none does
  int usual = -1;  ///< what alone may stand there, and may be left out: the record is known by it; -1: any number

  bool is_array() const { return count > 1; }
};

/// One record that the proxy carries and does not act on (wsn.md 7.2): learning, synaptic channels, and the messages
/// that a mote exchanges on its own serial port.
struct LearningRecord {
  std::string_view name;         ///< as in wsn.md 7.2, without "Msg"
  std::uint8_t type = 0;         ///< in the motes' one enumeration of AM and record types
  std::uint8_t transport = 0;    ///< 0: not known, or not inside a radio message
  std::uint8_t application = 0;  ///< as transport
  std::size_t size = 0;          ///< bytes, with all of its arrays
  std::span<const RecordField> fields;
  bool own_packet = false;  ///< an AM packet of its own, not inside a radio message

  const RecordField* find(std::string_view field) const;
};

std::span<const LearningRecord> learning_records();
/// By name, with or without "Msg" behind it; nullptr if there is none.
const LearningRecord* find_learning_record(std::string_view name);
const LearningRecord* find_learning_record(std::uint8_t type);

/// The record in a message of the learning or synaptic application, by what its first byte says in that direction;
/// nullptr if nobody knows. The two forms of an upload (weights, floats) look alike: it is told as weights, which loses
/// nothing. Whether motes with learning send exactly this is unverified: their firmware was never released.
const LearningRecord* learning_record_in(const NetMessage& message);

/// Numbers by field name; exactly one where the field is no array.
using FieldValues = std::map<std::string, std::vector<double>, std::less<>>;

/// The record in full length, arrays filled up with zeros. The field that counts an array may be left out. kNotFound
/// for an unknown record; kOutOfRange, kInvalid: an unknown, missing or unfit field, with record, field and range.
Result<Bytes> encode_learning(std::string_view name, const FieldValues& values);

/// Of the record's bytes, with whatever stands behind it. A counted array has the elements that count; an array at the
/// end those that are there. kInvalid if the record is cut short or counts more than there is room for.
Result<FieldValues> decode_learning(std::uint8_t type, ByteView bytes);
Result<FieldValues> decode_learning(const LearningRecord& record, ByteView bytes);

/// A matrix for upload in chunks of 92 bytes, each for one record (wsn.md 7.2): length / 92 + 1 of them, so that an
/// exact multiple ends with an empty one. Views of `matrix`.
inline constexpr std::size_t kMatrixChunk = 92;
std::vector<ByteView> matrix_chunks(ByteView matrix);

}  // namespace rubicon::motes
