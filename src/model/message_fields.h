#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "model/message.h"
#include "rubicon/result.hpp"

namespace rubicon::model {

/// Reads the fields of one CBOR map, keeping the first error of the whole message.
class FieldReader {
 public:
  FieldReader(const nlohmann::json& map, std::string path, Error& error);

  bool ok() const { return error_->text.empty(); }
  bool has(const char* key) const { return map_ && map_->contains(key); }

  std::uint64_t number(const char* key, std::uint64_t maximum);
  std::int64_t signed_number(const char* key);
  double real(const char* key);
  bool boolean(const char* key);
  /// Absent gives an empty text.
  std::string text(const char* key, std::size_t maximum = 4096);
  Bytes bytes(const char* key);
  Value value(const char* key);
  FieldReader map(const char* key);
  /// A list of texts that are not empty; absent is an empty list.
  std::vector<std::string> names(const char* key, std::size_t most, std::size_t longest);
  /// Each map of a list; absent is an empty list.
  void each(const char* key, const std::function<void(FieldReader&)>& visit);
  /// Names and numbers of a map; absent is empty.
  std::map<std::string, std::uint64_t> counters(const char* key);
  std::map<std::string, std::string> texts(const char* key);

  void wrong(const char* key, std::string_view expected);

 private:
  const nlohmann::json* find(const char* key) const;

  const nlohmann::json* map_;
  std::string path_;
  Error* error_;
};

/// Whether the bytes are one CBOR item of the plain kind the form uses; guards the parser against hostile nesting.
Result<void> check_cbor(ByteView bytes);

/// A value as CBOR: JSON values as `{"json": text}`, the rest as what they are.
nlohmann::json value_to_json(const Value& value);

/// Longest request of a tool to a network, in bytes. Networks refuse longer ones; the audit reads all others.
inline constexpr std::size_t kMaxToolRequest = 64UL * 1024;

/// The JSON object of a request of a tool, such as `knx.request`; kInvalid if it is longer or no object.
Result<nlohmann::json> read_tool_request(const Opaque& request);

}  // namespace rubicon::model
