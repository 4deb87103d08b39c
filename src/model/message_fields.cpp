#include "model/message_fields.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "model/json_text.h"
#include "model/message.h"

namespace rubicon::model {

using nlohmann::json;

FieldReader::FieldReader(const json& map, std::string path, Error& error)
    : map_(&map), path_(std::move(path)), error_(&error) {
  if (map.is_object()) return;
  map_ = nullptr;
  if (ok()) *error_ = {ErrorCode::kInvalid, fmt::format("message: {} is not a map", path_)};
}

const json* FieldReader::find(const char* key) const {
  if (!map_) return nullptr;
  const auto found = map_->find(key);
  return found == map_->end() ? nullptr : &*found;
}

void FieldReader::wrong(const char* key, std::string_view expected) {
  if (!ok()) return;
  const auto* where = path_.empty() ? "" : ".";
  *error_ = {ErrorCode::kInvalid, fmt::format("message: {}{}{}: expected {}", path_, where, key, expected)};
}

std::uint64_t FieldReader::number(const char* key, std::uint64_t maximum) {
  const auto* found = find(key);
  if (!found) return 0;
  if (found->is_number_unsigned() && found->get<std::uint64_t>() <= maximum) return found->get<std::uint64_t>();
  wrong(key, fmt::format("a whole number from 0 to {}", maximum));
  return 0;
}

std::int64_t FieldReader::signed_number(const char* key) {
  const auto* found = find(key);
  if (!found) return 0;
  const bool fits = found->is_number_integer() &&
                    (!found->is_number_unsigned() || found->get<std::uint64_t>() <= std::uint64_t{INT64_MAX});
  if (fits) return found->get<std::int64_t>();
  wrong(key, "a whole number of 64 bits");
  return 0;
}

double FieldReader::real(const char* key) {
  const auto* found = find(key);
  if (found && found->is_number() && std::isfinite(found->get<double>())) return found->get<double>();
  if (found) wrong(key, "a finite number");
  return 0;
}

bool FieldReader::boolean(const char* key) {
  const auto* found = find(key);
  if (found && found->is_boolean()) return found->get<bool>();
  if (found) wrong(key, "true or false");
  return false;
}

std::string FieldReader::text(const char* key, std::size_t maximum) {
  const auto* found = find(key);
  if (!found) return {};
  if (found->is_string() && found->get_ref<const std::string&>().size() <= maximum) return found->get<std::string>();
  wrong(key, fmt::format("a text of at most {} bytes", maximum));
  return {};
}

std::vector<std::string> FieldReader::names(const char* key, std::size_t most, std::size_t longest) {
  const auto* found = find(key);
  if (!found) return {};
  const auto is_name = [longest](const json& one) {
    if (!one.is_string()) return false;
    const auto& text = one.get_ref<const std::string&>();
    return !text.empty() && text.size() <= longest;
  };
  if (found->is_array() && found->size() <= most && std::all_of(found->begin(), found->end(), is_name))
    return found->get<std::vector<std::string>>();
  wrong(key, fmt::format("a list of at most {} texts of 1 to {} bytes", most, longest));
  return {};
}

Bytes FieldReader::bytes(const char* key) {
  const auto* found = find(key);
  if (!found) return {};
  if (found->is_binary()) return static_cast<const Bytes&>(found->get_binary());
  wrong(key, "a byte string");
  return {};
}

Value FieldReader::value(const char* key) {
  const auto* found = find(key);
  if (!found || found->is_null()) return {};
  if (found->is_boolean()) return found->get<bool>();
  if (found->is_number_integer()) return signed_number(key);
  if (found->is_number_float()) return real(key);
  if (found->is_string()) return text(key, 65536);
  if (found->is_object()) {
    auto text = FieldReader(*found, path_ + "." + key, *error_).text("json", 65536);
    if (is_json(text)) return Json{std::move(text)};
  }
  wrong(key, "null, true, false, a number, a text or {\"json\": JSON text}");
  return {};
}

FieldReader FieldReader::map(const char* key) {
  static const json kEmpty = json::object();
  const auto* found = find(key);
  return FieldReader(found ? *found : kEmpty, path_.empty() ? key : path_ + "." + key, *error_);
}

void FieldReader::each(const char* key, const std::function<void(FieldReader&)>& visit) {
  const auto* found = find(key);
  if (!found) return;
  if (!found->is_array() || found->size() > kMaxMessageEntries) {
    return wrong(key, fmt::format("a list of at most {} maps", kMaxMessageEntries));
  }
  for (std::size_t i = 0; i < found->size() && ok(); ++i) {
    FieldReader item((*found)[i], fmt::format("{}.{}[{}]", path_, key, i), *error_);
    if (item.ok()) visit(item);
  }
}

std::map<std::string, std::uint64_t> FieldReader::counters(const char* key) {
  std::map<std::string, std::uint64_t> out;
  const auto* found = find(key);
  if (!found) return out;
  if (!found->is_object() || found->size() > kMaxMessageEntries) {
    wrong(key, "a map of names to numbers");
    return out;
  }
  for (const auto& [name, count] : found->items()) {
    if (!count.is_number_unsigned()) {
      wrong(key, "whole numbers from 0");
      return out;
    }
    out.emplace(name, count.get<std::uint64_t>());
  }
  return out;
}

/// Of the texts of a State.
constexpr std::size_t kMaxTextLength = 64UL * 1024;

std::map<std::string, std::string> FieldReader::texts(const char* key) {
  std::map<std::string, std::string> out;
  const auto* found = find(key);
  if (!found) return out;
  const auto fits = [](const auto& text) {
    return text.is_string() && text.template get_ref<const std::string&>().size() <= kMaxTextLength;
  };
  if (!found->is_object() || found->size() > kMaxMessageEntries || !std::all_of(found->begin(), found->end(), fits)) {
    wrong(key, "a map of names to texts of at most 64 KiB");
    return out;
  }
  for (const auto& [name, text] : found->items()) out.emplace(name, text.get<std::string>());
  return out;
}

json value_to_json(const Value& value) {
  struct Writer {
    json operator()(std::monostate) const { return nullptr; }
    json operator()(bool on) const { return on; }
    json operator()(std::int64_t number) const { return number; }
    json operator()(double number) const { return std::isfinite(number) ? json(number) : json(); }
    json operator()(const std::string& text) const { return text; }
    json operator()(const Json& structured) const { return json{{"json", structured.text}}; }
  };
  return std::visit(Writer{}, value);
}

namespace {

constexpr int kMaxDepth = 8;

/// Walks a CBOR item (RFC 8949, section 3) without building it: lengths fit, nesting is shallow, text keys only. The
/// form uses definite lengths and no tags, so anything else is refused before a parser sees it.
class CborWalk {
 public:
  explicit CborWalk(ByteView bytes) : in_(bytes) {}

  bool item(int depth) {
    const auto first = in_.u8();
    const auto major = first >> 5;
    const auto argument = length(first & 31U);
    if (!in_.ok() || depth > kMaxDepth) return false;
    switch (major) {
      case 0: return true;
      case 1: return argument <= std::uint64_t{INT64_MAX};  // the parser would wrap round below -2^63
      case 2:
      case 3: return take(argument);
      case 4: return items(argument, depth, false);
      case 5: return items(argument, depth, true);
      case 7: return (first & 31U) >= 20 && (first & 31U) <= 27 && (first & 31U) != 24;
      default: return false;
    }
  }

  bool at_end() const { return in_.ok() && in_.remaining() == 0; }
  std::size_t position() const { return in_.position(); }

 private:
  std::uint64_t length(unsigned low) {
    if (low < 24) return low;
    switch (low) {
      case 24: return in_.u8();
      case 25: return in_.u16_be();
      case 26: return in_.u32_be();
      case 27: return in_.u64_be();
      default: in_.take(in_.remaining() + 1); return 0;  // indefinite or reserved: not in our form
    }
  }

  bool take(std::uint64_t count) {
    if (count > in_.remaining()) return false;
    in_.skip(static_cast<std::size_t>(count));
    return true;
  }

  bool items(std::uint64_t count, int depth, bool map) {
    if (count > in_.remaining()) return false;  // each takes at least a byte
    for (; count > 0; --count) {
      if (map && !text_key()) return false;
      if (!item(depth + 1)) return false;
    }
    return true;
  }

  bool text_key() {
    const auto first = in_.u8();
    return in_.ok() && first >> 5 == 3 && take(length(first & 31U)) && in_.ok();
  }

  base::ByteReader in_;
};

}  // namespace

Result<void> check_cbor(ByteView bytes) {
  CborWalk walk(bytes);
  if (walk.item(0) && walk.at_end()) return {};
  return fail(ErrorCode::kInvalid,
              fmt::format("message: not CBOR of definite lengths, text keys and at most {} levels, at byte {} of {}",
                          kMaxDepth, walk.position(), bytes.size()));
}

Result<nlohmann::json> read_tool_request(const Opaque& request) {
  if (request.bytes.size() > kMaxToolRequest)
    return fail(ErrorCode::kInvalid, fmt::format("a {} of {} bytes, expected at most {}", request.type,
                                                 request.bytes.size(), kMaxToolRequest));
  auto object = parse_json(base::as_text(request.bytes));
  if (!object.is_object()) return fail(ErrorCode::kInvalid, fmt::format("a {} is a JSON object", request.type));
  return object;
}

}  // namespace rubicon::model
