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

/// The encoding of a number in a record (wsn.md 7.2): integers big-endian, floats IEEE 754 single, little-endian.
enum class FieldKind : std::uint8_t { kU8, kI8, kU16, kFloat };

/// Position and content of a field in its record.
struct RecordField {
  std::string_view name;
  FieldKind kind = FieldKind::kU8;
  std::size_t offset = 0;
  std::size_t count = 1;             ///< 1: a number; more: an array of at most this many
  std::string_view counted_by = {};  ///< the preceding field with the number of valid elements; empty: none
  int fixed = -1;  ///< the only permitted value, by which the record is recognised, may be omitted; -1: any value

  bool is_array() const { return count > 1; }
};

/// A record that the proxy forwards without interpreting it (wsn.md 7.2): learning, synaptic channels, and the messages
/// that a mote exchanges on its own serial port.
struct LearningRecord {
  std::string_view name;         ///< as in wsn.md 7.2, without "Msg"
  std::uint8_t type = 0;         ///< AM and record types of the motes share one enumeration
  std::uint8_t transport = 0;    ///< 0: unknown, or not part of a radio message
  std::uint8_t application = 0;  ///< as transport
  std::size_t size = 0;          ///< bytes, with full arrays
  std::span<const RecordField> fields;
  bool own_packet = false;  ///< an AM packet of its own, not part of a radio message

  const RecordField* find(std::string_view field) const;
};

std::span<const LearningRecord> learning_records();
/// By name, with or without the ending "Msg"; nullptr if unknown.
const LearningRecord* find_learning_record(std::string_view name);
const LearningRecord* find_learning_record(std::uint8_t type);

/// The record in a message of the learning or synaptic application, by the first byte and the direction; nullptr if
/// unknown. The two forms of an upload (weights, floats) cannot be distinguished: both are returned as weights, which
/// loses nothing. Whether motes with learning send exactly this is unverified: their firmware was never released.
const LearningRecord* learning_record_in(const NetMessage& message);

/// Numbers by field name; exactly one for fields that are not arrays.
using FieldValues = std::map<std::string, std::vector<double>, std::less<>>;

/// The record at full length, arrays filled up with zeros. The count of an array may be omitted. kNotFound: unknown
/// record. kOutOfRange, kInvalid: an unknown, missing or wrong field; the text names record, field and range.
Result<Bytes> encode_learning(std::string_view name, const FieldValues& values);

/// Decodes a record; further bytes after it are ignored. A counted array gets the counted elements, one at the end
/// those that are there. kInvalid if the record is cut short or a count exceeds the array.
Result<FieldValues> decode_learning(std::uint8_t type, ByteView bytes);
Result<FieldValues> decode_learning(const LearningRecord& record, ByteView bytes);

/// Splits a matrix for upload into chunks of 92 bytes, each for one record (wsn.md 7.2): length / 92 + 1 of them, so
/// that an exact multiple ends with an empty one. Views of `matrix`.
inline constexpr std::size_t kMatrixChunk = 92;
std::vector<ByteView> matrix_chunks(ByteView matrix);

}  // namespace rubicon::motes
