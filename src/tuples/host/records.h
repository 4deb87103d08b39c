#pragma once

#include <span>
#include <string_view>

#include "base/bytes.h"
#include "rubicon/address.hpp"
#include "rubicon/result.hpp"

namespace rubicon::tuples::host {

/// What one process sends to another. Each record has a type and the same fields; those that its type does not name are
/// zero or empty.
struct Record {
  enum class Type : std::uint8_t {
    kHello = 1,   ///< the first: number = version of the protocol, text = token of the sender
    kUp,          ///< component id of the sender is there: number = incarnation, text = host, content = summary
    kDown,        ///< it left
    kSummary,     ///< content = its summary
    kInterest,    ///< it subscribes: content as FrameWriter::add(SubscriptionSpec)
    kNoInterest,  ///< no longer: number = id of the subscription
    kFrame,       ///< to component target: number = its incarnation, content = entries of FrameWriter. Times to live in
                  ///< it are ends, by Folder::since_boot()
    kReady,       ///< all components were told
    kAsk,         ///< does the receiver live? It answers at once
    kAnswer,
    kGoodbye  ///< the sender ends: its components leave
  };

  Type type = Type::kHello;
  OwnerId id{}, target{};
  std::uint64_t number = 0;
  std::string_view text{};  ///< at most kMaxText bytes
  ByteView content{};

  static constexpr std::size_t kMaxText = 64;
};

inline constexpr std::uint64_t kProtocolVersion = 1;
/// Longest record: the largest value with its key and texts.
inline constexpr std::size_t kMaxRecord = (std::size_t{1024} + 64) * 1024;
/// Bytes of the size before each record, lowest first.
inline constexpr std::size_t kSizeBytes = 4;

/// Appends the record with its size.
void append(Bytes& out, const Record& record);
/// Writes the size of the record that these bytes are.
void put_size(std::span<std::uint8_t> record);
/// Reads one record without its size; the views are into it. kInvalid names its type.
Result<Record> read_record(ByteView bytes);
/// 16 hexadecimal digits in lower case.
bool is_token(std::string_view text);

}  // namespace rubicon::tuples::host
