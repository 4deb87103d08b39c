#include "tuples/host/records.h"

#include <fmt/format.h>

#include <algorithm>

#include "tuples/distant/fields.h"

namespace rubicon::tuples::host {

namespace {

constexpr std::size_t kTokenDigits = 16;

}  // namespace

void append(Bytes& out, const Record& record) {
  const auto begin = out.size();
  distant::FieldWriter fields;
  fields.byte(static_cast<std::uint8_t>(record.type));
  fields.number(number(record.id));
  fields.number(number(record.target));
  fields.number(record.number);
  fields.text(record.text);
  const auto head = fields.view();
  out.resize(begin + kSizeBytes);
  out.insert(out.end(), head.begin(), head.end());
  out.insert(out.end(), record.content.begin(), record.content.end());
  put_size(std::span(out).subspan(begin));
}

void put_size(std::span<std::uint8_t> record) {
  const auto size = record.size() - kSizeBytes;
  for (std::size_t at = 0; at < kSizeBytes; ++at) record[at] = static_cast<std::uint8_t>(size >> (8 * at) & 0xff);
}

Result<Record> read_record(ByteView bytes) {
  distant::FieldReader in(bytes);
  Record record;
  const auto type = in.byte();
  record.type = static_cast<Record::Type>(type);
  record.id = in.owner();
  record.target = in.owner();
  record.number = in.number();
  record.text = in.text();
  record.content = in.rest();
  const bool known = type >= static_cast<std::uint8_t>(Record::Type::kHello) &&
                     type <= static_cast<std::uint8_t>(Record::Type::kGoodbye);
  if (in.ok() && known && record.text.size() <= Record::kMaxText) return record;
  return fail(ErrorCode::kInvalid, fmt::format("invalid record of type {}", type));
}

bool is_token(std::string_view text) {
  return text.size() == kTokenDigits &&
         std::all_of(text.begin(), text.end(), [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); });
}

}  // namespace rubicon::tuples::host
