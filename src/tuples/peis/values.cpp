#include "tuples/peis/values.h"

#include "base/utf8.h"
#include "tuples/peis/wire.h"

namespace rubicon::tuples::peis {

namespace {

bool is_utf8_without_nul(std::string_view text) {
  while (!text.empty()) {
    const auto character = base::take_utf8(text);
    if (!character || *character == 0) return false;
  }
  return true;
}

bool is_text(std::string_view media_type) {
  return media_type.starts_with("text/");
}

}  // namespace

WireValue to_wire(std::string_view value, std::string_view media_type) {
  WireValue wire{Encoding::kBinary, std::string(value)};
  if (!is_text(media_type) && !is_utf8_without_nul(value)) return wire;
  wire.encoding = Encoding::kAscii;
  wire.data += '\0';
  return wire;
}

std::string_view from_wire(Encoding encoding, std::string_view data) {
  const bool has_nul = encoding == Encoding::kAscii && data.ends_with('\0');
  return has_nul ? data.substr(0, data.size() - 1) : data;
}

std::string_view from_kernel(Encoding encoding, std::string_view data, std::string_view media_type) {
  if (data == std::string_view("\0", 1)) return {};
  const auto first = data.find('\0');
  const bool others = first != data.npos && first + 1 < data.size();
  return others && !is_text(media_type) ? data : from_wire(encoding, data);
}

std::string appended(Encoding encoding, std::string_view data, std::string_view difference) {
  std::string whole(from_wire(encoding, data));
  whole += difference;
  return whole;
}

OwnerId creator_on_wire(OwnerId creator, OwnerId owner) {
  return creator == OwnerId{} || number(creator) > kMaxId ? owner : creator;
}

std::string_view media_type_on_wire(std::string_view media_type) {
  return media_type.empty() ? "text/plain" : media_type.substr(0, kMaxMediaType);
}

NetworkTuple tuple_on_wire(const TupleView& tuple, const WireValue& value, OwnerId self) {
  NetworkTuple out;
  out.owner = self;
  out.key = tuple.key;
  out.creator = creator_on_wire(tuple.creator, self);
  out.write_time = tuple.write_time;
  out.user_time = tuple.user_time;
  out.expire_time = tuple.expire_time;
  out.encoding = value.encoding;
  out.media_type = media_type_on_wire(tuple.media_type);
  out.data = value.data;
  return out;
}

}  // namespace rubicon::tuples::peis
