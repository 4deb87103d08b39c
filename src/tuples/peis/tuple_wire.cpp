#include "tuples/peis/tuple_wire.h"

#include "base/assert.h"
#include "tuples/peis/fields.h"
#include "tuples/peis/wire.h"

namespace rubicon::tuples::peis {

namespace {

constexpr std::size_t kAnnexAt = 48, kKeyAt = 84, kKeyField = kMaxPeisKey + 1;
constexpr std::size_t kForceSize = 4, kDifferenceSize = 4;
constexpr std::uint32_t kOpen = 0xffffffff;
constexpr std::uint8_t kMediaTypeAbsent = 255;
constexpr std::int64_t kSecond = 1000000;

/// The 224 bytes, and what they say about the bytes behind them.
struct FixedPart {
  NetworkTuple tuple;
  std::size_t media_type_length = 0;
  bool has_data = false;
  std::uint32_t data_length = 0;
};

/// Which byte of the flag at 40 is 1: PUSH_TUPLE and PUSH_APPENDED write it little-endian, all others big-endian.
enum class DataFlag : std::uint8_t { kLittleEndian = 40, kBigEndian = 43 };

Result<std::optional<OwnerId>> owner_at(std::string_view body, std::string_view field, ByteView bytes, std::size_t at) {
  const auto id = u32_at(bytes, at);
  if (id == kOpen) return std::nullopt;
  if (id <= kMaxId) return OwnerId{id};
  return wrong_field(body, fmt::format("{} at {}: {:08x}, expected 0 to 7fffffff or ffffffff", field, at, id));
}

/// Kernels pass on what an application sets: microseconds may be more than a second.
Result<std::optional<WallTime>> time_at(std::string_view body, std::string_view field, ByteView bytes, std::size_t at) {
  const auto seconds = u32_at(bytes, at), microseconds = u32_at(bytes, at + 4);
  if (seconds == kOpen && microseconds == kOpen) return std::nullopt;
  if (seconds > kMaxId || microseconds > kMaxId)
    return wrong_field(
        body, fmt::format("{} at {}: {:08x} {:08x}, expected no negative numbers", field, at, seconds, microseconds));
  const auto latest = std::int64_t{kMaxId} * kSecond + kSecond - 1;
  return WallTime(std::chrono::microseconds(std::min(seconds * kSecond + microseconds, latest)));
}

void put_time(std::span<std::uint8_t> out, std::size_t at, const std::optional<WallTime>& time) {
  const auto latest = std::int64_t{kMaxId} * kSecond + kSecond - 1;
  const auto count = time ? std::clamp<std::int64_t>(time->time_since_epoch().count(), 0, latest) : 0;
  put_u32(out, at, time ? static_cast<std::uint32_t>(count / kSecond) : kOpen);
  put_u32(out, at + 4, time ? static_cast<std::uint32_t>(count % kSecond) : kOpen);
}

Result<std::optional<Encoding>> encoding_at(std::string_view body, ByteView bytes) {
  const auto encoding = u32_at(bytes, 32);
  if (encoding == kOpen) return std::nullopt;
  if (encoding <= 1) return Encoding(encoding);
  return wrong_field(body, fmt::format("encoding at 32: {:08x}, expected 0, 1 or ffffffff", encoding));
}

Annex annex_at(ByteView bytes) {
  Annex annex{};
  const auto field = bytes.subspan(kAnnexAt, annex.size());
  if (std::equal(kAnnexMark.begin(), kAnnexMark.end(), field.begin()))
    std::copy(field.begin(), field.end(), annex.begin());
  return annex;
}

Result<void> read_ids_and_times(std::string_view body, ByteView bytes, NetworkTuple& tuple) {
  const auto owner = owner_at(body, "owner", bytes, 0);
  if (!owner) return fail(owner.error());
  tuple.owner = *owner;
  const auto creator = owner_at(body, "creator", bytes, 4);
  if (!creator) return fail(creator.error());
  tuple.creator = *creator;
  const auto written = time_at(body, "write time", bytes, 8);
  if (!written) return fail(written.error());
  tuple.write_time = *written;
  const auto user = time_at(body, "user time", bytes, 16);
  if (!user) return fail(user.error());
  tuple.user_time = *user;
  const auto expires = time_at(body, "expire time", bytes, 24);
  if (!expires) return fail(expires.error());
  tuple.expire_time = *expires;
  return {};
}

Result<FixedPart> read_fixed(std::string_view body, ByteView bytes) {
  if (bytes.size() < kNetworkTupleSize)
    return wrong_field(body, fmt::format("{} bytes, a tuple has {}", bytes.size(), kNetworkTupleSize));
  FixedPart part;
  auto& tuple = part.tuple;
  if (const auto good = read_ids_and_times(body, bytes, tuple); !good) return fail(good.error());
  const auto encoding = encoding_at(body, bytes);
  if (!encoding) return fail(encoding.error());
  tuple.encoding = *encoding;
  const auto key = text_at(body, "key", bytes, kKeyAt, kKeyField);
  if (!key) return fail(key.error());
  tuple.key = *key;
  if (const auto sequence = u32_at(bytes, 216); sequence != kOpen) tuple.sequence = sequence;
  tuple.appends = u32_at(bytes, 220);
  tuple.annex = annex_at(bytes);
  part.media_type_length = bytes[36] == kMediaTypeAbsent ? 0 : bytes[36];
  part.has_data = u32_at(bytes, 40) != 0;
  part.data_length = u32_at(bytes, 44);
  return part;
}

/// Cuts the media type off the bytes behind the tuple.
Result<std::string_view> take_media_type(std::string_view body, const FixedPart& part, ByteView& rest) {
  if (part.media_type_length > rest.size())
    return wrong_field(body, fmt::format("media type of {} bytes (at 36), but {} bytes follow the tuple",
                                         part.media_type_length, rest.size()));
  const auto text = base::as_text(rest.first(part.media_type_length));
  rest = rest.subspan(part.media_type_length);
  return text;
}

/// Cuts off the data of a prototype, whose length must be zero if it has none: kernels skip that many bytes anyway.
Result<std::optional<std::string_view>> take_data(std::string_view body, const FixedPart& part, ByteView& rest) {
  if (!part.has_data && part.data_length != 0)
    return wrong_field(body, fmt::format("data length at 44: {}, expected 0 without data", part.data_length));
  if (part.data_length > rest.size())
    return wrong_field(body,
                       fmt::format("data of {} bytes (at 44), but {} bytes follow", part.data_length, rest.size()));
  const auto text = base::as_text(rest.first(part.data_length));
  rest = rest.subspan(part.data_length);
  if (!part.has_data) return std::nullopt;
  return text;
}

Result<void> expect_end(std::string_view body, ByteView rest) {
  if (rest.empty()) return {};
  return wrong_field(body, fmt::format("{} bytes behind the end, expected none", rest.size()));
}

Result<NetworkTuple> read_whole(std::string_view body, ByteView bytes) {
  auto part = read_fixed(body, bytes);
  if (!part) return fail(part.error());
  auto rest = bytes.subspan(kNetworkTupleSize);
  const auto media_type = take_media_type(body, *part, rest);
  if (!media_type) return fail(media_type.error());
  part->tuple.media_type = *media_type;
  if (part->has_data) part->tuple.data = base::as_text(rest);
  if (const auto concrete = check_concrete(part->tuple); !concrete) return wrong_field(body, concrete.error().text);
  return std::move(part->tuple);
}

std::size_t data_size(const std::optional<std::string_view>& data) {
  return data ? data->size() : 0;
}

void append_text(Bytes& out, std::string_view text) {
  out.insert(out.end(), text.begin(), text.end());
}

/// Appends the 224 bytes. `isNew` says whether this is a tuple or a prototype.
void append_fixed(Bytes& out, const NetworkTuple& tuple, std::uint32_t is_new, DataFlag flag) {
  RUBICON_ASSERT(tuple.key.size() <= kMaxPeisKey && tuple.key.find('\0') == tuple.key.npos);
  RUBICON_ASSERT(tuple.media_type.size() <= kMaxMediaType && data_size(tuple.data) <= kMaxId);
  const auto begin = out.size();
  out.resize(begin + kNetworkTupleSize);
  const auto field = std::span(out).subspan(begin);
  put_id(field, 0, tuple.owner.value_or(OwnerId{kOpen}));
  put_id(field, 4, tuple.creator.value_or(OwnerId{kOpen}));
  put_time(field, 8, tuple.write_time);
  put_time(field, 16, tuple.user_time);
  put_time(field, 24, tuple.expire_time);
  put_u32(field, 32, tuple.encoding ? static_cast<std::uint32_t>(*tuple.encoding) : kOpen);
  field[36] = static_cast<std::uint8_t>(tuple.media_type.size());
  field[static_cast<std::size_t>(flag)] = tuple.data ? 1 : 0;
  put_u32(field, 44, static_cast<std::uint32_t>(data_size(tuple.data)));
  put_bytes(field, kAnnexAt, tuple.annex);
  put_bytes(field, kKeyAt, base::as_bytes(tuple.key));
  put_u32(field, 212, is_new);
  put_u32(field, 216, tuple.sequence.value_or(kOpen));
  put_u32(field, 220, tuple.appends);
}

void write_whole(const NetworkTuple& tuple, DataFlag flag, Bytes& out) {
  RUBICON_ASSERT(check_concrete(tuple).has_value());
  out.clear();
  out.reserve(kNetworkTupleSize + tuple.media_type.size() + tuple.data->size());
  append_fixed(out, tuple, 1, flag);
  append_text(out, tuple.media_type);
  append_text(out, *tuple.data);
}

void append_difference_length(Bytes& out, std::string_view difference) {
  RUBICON_ASSERT(difference.size() <= kMaxId);
  out.resize(out.size() + kDifferenceSize);
  put_u32(out, out.size() - kDifferenceSize, static_cast<std::uint32_t>(difference.size()));
}

/// The length of the difference, which stands behind the tuple.
Result<std::size_t> difference_length(std::string_view body, ByteView bytes) {
  if (bytes.size() >= kNetworkTupleSize + kDifferenceSize) return u32_at(bytes, kNetworkTupleSize);
  return wrong_field(body, fmt::format("{} bytes, tuple and length of the difference have {}", bytes.size(),
                                       kNetworkTupleSize + kDifferenceSize));
}

Result<std::string_view> read_difference(std::string_view body, std::size_t length, ByteView rest) {
  if (length == rest.size()) return base::as_text(rest);
  return wrong_field(
      body, fmt::format("difference of {} bytes (at {}), but {} bytes follow", length, kNetworkTupleSize, rest.size()));
}

}  // namespace

Result<void> check_concrete(const NetworkTuple& tuple) {
  const auto open = [](std::string_view field) {
    return fail(ErrorCode::kInvalid, fmt::format("no {}, which a tuple must have", field));
  };
  if (!tuple.owner) return open("owner");
  if (tuple.key.empty()) return open("key");
  if (tuple.key.find('*') != tuple.key.npos) return fail(ErrorCode::kInvalid, "key with wildcards, expected none");
  if (!tuple.creator) return open("creator");
  if (!tuple.user_time) return open("user time");
  if (!tuple.expire_time) return open("expire time");
  if (!tuple.encoding) return open("encoding");
  if (tuple.media_type.empty()) return open("media type");
  if (!tuple.data || tuple.data->empty()) return open("data");
  return {};
}

Result<NetworkTuple> read_push(ByteView body) {
  constexpr std::string_view kBody = "PUSH_TUPLE";
  auto tuple = read_whole(kBody, body);
  if (!tuple) return tuple;
  if (!tuple->write_time) return wrong_field(kBody, "no write time, which a push must have");
  if (!tuple->sequence) return wrong_field(kBody, "no sequence, which a push must have");
  return tuple;
}

Bytes write_push(const NetworkTuple& tuple) {
  Bytes out;
  write_push_into(tuple, out);
  return out;
}

void write_push_into(const NetworkTuple& tuple, Bytes& out) {
  RUBICON_ASSERT(tuple.write_time && tuple.sequence);
  write_whole(tuple, DataFlag::kLittleEndian, out);
}

Result<NetworkTuple> read_set_remote(ByteView body) {
  return read_whole("SET_REMOTE", body);
}

Bytes write_set_remote(const NetworkTuple& tuple) {
  Bytes out;
  write_whole(tuple, DataFlag::kBigEndian, out);
  return out;
}

Result<Subscribe> read_subscribe(ByteView body) {
  constexpr std::string_view kBody = "SUBSCRIBE";
  if (body.size() < kForceSize)
    return wrong_field(kBody, fmt::format("{} bytes, expected at least {}", body.size(), kForceSize));
  const auto bytes = body.subspan(kForceSize);
  auto part = read_fixed(kBody, bytes);
  if (!part) return fail(part.error());
  auto rest = bytes.subspan(kNetworkTupleSize);
  const auto media_type = take_media_type(kBody, *part, rest);
  if (!media_type) return fail(media_type.error());
  part->tuple.media_type = *media_type;
  const auto data = take_data(kBody, *part, rest);
  if (!data) return fail(data.error());
  part->tuple.data = *data;
  if (const auto end = expect_end(kBody, rest); !end) return fail(end.error());
  return Subscribe{u32_le_at(body, 0) != 0, std::move(part->tuple)};
}

Bytes write(const Subscribe& subscribe) {
  Bytes out(kForceSize);
  put_u32_le(out, 0, subscribe.force_resend ? 1 : 0);
  append_fixed(out, subscribe.prototype, kOpen, DataFlag::kBigEndian);
  append_text(out, subscribe.prototype.media_type);
  append_text(out, subscribe.prototype.data.value_or(std::string_view()));
  return out;
}

Result<Unsubscribe> read_unsubscribe(ByteView body) {
  constexpr std::string_view kBody = "UNSUBSCRIBE";
  if (body.size() < kNetworkTupleSize)
    return wrong_field(kBody, fmt::format("{} bytes, expected at least {}", body.size(), kNetworkTupleSize));
  const auto owner = owner_at(kBody, "owner", body, 0);
  if (!owner) return fail(owner.error());
  const auto key = text_at(kBody, "key", body, kKeyAt, kKeyField);
  if (!key) return fail(key.error());
  FixedPart part;
  part.has_data = u32_at(body, 40) != 0;
  part.data_length = u32_at(body, 44);
  auto rest = body.subspan(kNetworkTupleSize);
  const auto data = take_data(kBody, part, rest);
  if (!data) return fail(data.error());
  if (const auto end = expect_end(kBody, rest); !end) return fail(end.error());
  return Unsubscribe{*owner, *key, *data, annex_at(body)};
}

Bytes write(const Unsubscribe& unsubscribe) {
  NetworkTuple prototype;
  prototype.owner = unsubscribe.owner;
  prototype.key = unsubscribe.key;
  prototype.data = unsubscribe.data;
  prototype.annex = unsubscribe.annex;
  Bytes out;
  append_fixed(out, prototype, kOpen, DataFlag::kBigEndian);
  append_text(out, unsubscribe.data.value_or(std::string_view()));
  return out;
}

Result<SetAppend> read_set_append(ByteView body) {
  constexpr std::string_view kBody = "SET_APPEND";
  auto part = read_fixed(kBody, body);
  if (!part) return fail(part.error());
  const auto length = difference_length(kBody, body);
  if (!length) return fail(length.error());
  auto rest = body.subspan(kNetworkTupleSize + kDifferenceSize);
  const auto data = take_data(kBody, *part, rest);
  if (!data) return fail(data.error());
  part->tuple.data = *data;
  const auto difference = read_difference(kBody, *length, rest);
  if (!difference) return fail(difference.error());
  return SetAppend{std::move(part->tuple), *difference};
}

Bytes write(const SetAppend& append) {
  RUBICON_ASSERT(append.prototype.media_type.empty());
  Bytes out;
  append_fixed(out, append.prototype, kOpen, DataFlag::kBigEndian);
  append_difference_length(out, append.difference);
  append_text(out, append.prototype.data.value_or(std::string_view()));
  append_text(out, append.difference);
  return out;
}

Result<PushAppended> read_push_appended(ByteView body) {
  constexpr std::string_view kBody = "PUSH_APPENDED";
  auto part = read_fixed(kBody, body);
  if (!part) return fail(part.error());
  const auto length = difference_length(kBody, body);
  if (!length) return fail(length.error());
  const auto difference = read_difference(kBody, *length, body.subspan(kNetworkTupleSize + kDifferenceSize));
  if (!difference) return fail(difference.error());
  return PushAppended{std::move(part->tuple), body[36], part->data_length, *difference};
}

Bytes write(const PushAppended& appended) {
  RUBICON_ASSERT(appended.tuple.media_type.empty() && !appended.tuple.data);
  Bytes out;
  append_fixed(out, appended.tuple, 1, DataFlag::kLittleEndian);
  out[36] = appended.media_type_length;
  out[static_cast<std::size_t>(DataFlag::kLittleEndian)] = 1;
  put_u32(out, 44, appended.data_length);
  append_difference_length(out, appended.difference);
  append_text(out, appended.difference);
  return out;
}

}  // namespace rubicon::tuples::peis
