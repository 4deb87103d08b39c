#include "history/blocks.h"

#include <fmt/format.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <optional>

#include "base/assert.h"

namespace rubicon::history {

namespace {

constexpr std::array<double, 10> kPowers{1, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9};
constexpr std::uint8_t kDoubles = 15;          // in place of the number of digits
constexpr double kExact = 9007199254740992.0;  // 2^53: all whole numbers up to here are exact

/// The value as a whole number of 10^-digits, if that gives exactly the value again.
std::optional<std::int64_t> scaled(double value, std::size_t digits) {
  const double whole = std::nearbyint(value * kPowers[digits]);
  if (!(std::abs(whole) < kExact) || whole / kPowers[digits] != value) return std::nullopt;
  return static_cast<std::int64_t>(whole);
}

/// The least number of digits that keeps all values; kDoubles if none does.
std::uint8_t digits_of(std::span<const Point> points) {
  std::size_t digits = 0;
  for (const auto& point : points) {
    if (point.gap()) continue;
    while (digits < kPowers.size() && !scaled(point.value, digits)) ++digits;
    if (digits == kPowers.size()) return kDoubles;
  }
  // More digits can lose a large value that fewer digits kept.
  const bool all = std::all_of(points.begin(), points.end(),
                               [&](const Point& point) { return point.gap() || scaled(point.value, digits); });
  return all ? static_cast<std::uint8_t>(digits) : kDoubles;
}

void put_times(Bytes& out, std::span<const Point> points) {
  std::int64_t before = 0, step = 0;
  for (const auto& point : points) {
    const auto next = point.time - before;
    put_signed(out, next - step);
    step = next;
    before = point.time;
  }
}

void put_scaled(Bytes& out, std::span<const Point> points, std::size_t digits) {
  std::int64_t before = 0;
  for (const auto& point : points) {
    const auto now = point.gap() ? before : *scaled(point.value, digits);
    put_signed(out, now - before);
    before = now;
  }
}

/// Byte by byte of all values, the equal first bytes side by side: zstd packs that best.
void put_doubles(Bytes& out, std::span<const Point> points) {
  for (unsigned shift = 64; shift > 0;) {
    shift -= 8;
    for (const auto& point : points) {
      const auto bits = std::bit_cast<std::uint64_t>(point.gap() ? 0.0 : point.value);
      out.push_back(static_cast<std::uint8_t>(bits >> shift));
    }
  }
}

void put_gaps(Bytes& out, std::span<const Point> points) {
  std::size_t before = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].gap()) continue;
    put_number(out, i - before);
    before = i;
  }
}

/// Additions of a damaged file may overflow: they wrap.
std::int64_t wrapping_sum(std::int64_t a, std::int64_t b) {
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(a) + static_cast<std::uint64_t>(b));
}

bool take_times(NumberReader& reader, Points& points) {
  std::int64_t time = 0, step = 0;
  for (auto& point : points) {
    step = wrapping_sum(step, reader.signed_number());
    time = wrapping_sum(time, step);
    if (time < -kFurthest || time > kFurthest) return false;
    point.time = time;
  }
  return reader.ok();
}

bool take_scaled(NumberReader& reader, Points& points, std::size_t digits) {
  std::int64_t whole = 0;
  for (auto& point : points) {
    whole = wrapping_sum(whole, reader.signed_number());
    point.value = static_cast<double>(whole) / kPowers[digits];
  }
  return reader.ok();
}

bool take_doubles(NumberReader& reader, Points& points) {
  const auto planes = reader.take(points.size() * 8);
  if (!reader.ok()) return false;
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::uint64_t bits = 0;
    for (std::size_t plane = 0; plane < 8; ++plane) bits = bits << 8U | planes[plane * points.size() + i];
    points[i].value = std::bit_cast<double>(bits);
  }
  return std::none_of(points.begin(), points.end(), [](const Point& point) { return point.gap(); });
}

bool take_gaps(NumberReader& reader, Points& points, std::uint64_t count) {
  std::uint64_t place = 0;
  for (std::uint64_t i = 0; i < count; ++i) {
    const auto step = reader.number();
    if (!reader.ok() || step > points.size() || (i > 0 && step == 0)) return false;
    place += step;
    if (place >= points.size()) return false;
    points[place].value = kGap;
  }
  return true;
}

}  // namespace

void put_number(Bytes& out, std::uint64_t number) {
  while (number >= 0x80) {
    out.push_back(static_cast<std::uint8_t>(number | 0x80U));
    number >>= 7U;
  }
  out.push_back(static_cast<std::uint8_t>(number));
}

void put_signed(Bytes& out, std::int64_t number) {
  const auto bits = static_cast<std::uint64_t>(number);
  put_number(out, bits << 1U ^ (number < 0 ? ~std::uint64_t{0} : 0));
}

std::uint64_t NumberReader::number() {
  std::uint64_t sum = 0;
  for (unsigned shift = 0; shift < 64 && position_ < bytes_.size(); shift += 7) {
    const auto byte = bytes_[position_++];
    sum |= static_cast<std::uint64_t>(byte & 0x7fU) << shift;
    if (byte < 0x80) return sum;
  }
  ok_ = false;
  position_ = bytes_.size();
  return 0;
}

std::int64_t NumberReader::signed_number() {
  const auto bits = number();
  return static_cast<std::int64_t>(bits >> 1U ^ ((bits & 1U) != 0 ? ~std::uint64_t{0} : 0));
}

ByteView NumberReader::take(std::uint64_t count) {
  if (!ok_ || count > remaining()) {
    ok_ = false;
    position_ = bytes_.size();
    return {};
  }
  const auto part = bytes_.subspan(position_, static_cast<std::size_t>(count));
  position_ += static_cast<std::size_t>(count);
  return part;
}

Bytes pack_points(std::span<const Point> points) {
  RUBICON_ASSERT(points.size() <= kMaxPoints);
  Bytes out;
  out.reserve(points.size() * 3 + 16);
  const auto digits = digits_of(points);
  out.push_back(digits);
  put_number(out, points.size());
  put_times(out, points);
  if (digits == kDoubles) {
    put_doubles(out, points);
  } else {
    put_scaled(out, points, digits);
  }
  const auto gaps = std::count_if(points.begin(), points.end(), [](const Point& point) { return point.gap(); });
  put_number(out, static_cast<std::uint64_t>(gaps));
  put_gaps(out, points);
  return out;
}

Result<Points> unpack_points(ByteView bytes) {
  const auto damaged = [&](const char* what) {
    return fail(ErrorCode::kInvalid, fmt::format("a list of points of {} bytes: {}", bytes.size(), what));
  };
  if (bytes.empty()) return damaged("empty");
  const auto digits = bytes[0];
  if (digits >= kPowers.size() && digits != kDoubles) return damaged("unknown number of digits");
  NumberReader reader(bytes.subspan(1));
  const auto count = reader.number();
  // Each point has at least a byte for its time.
  if (!reader.ok() || count > kMaxPoints || count > reader.remaining()) return damaged("wrong number of points");
  Points points(static_cast<std::size_t>(count));
  if (!take_times(reader, points)) return damaged("wrong times");
  if (!(digits == kDoubles ? take_doubles(reader, points) : take_scaled(reader, points, digits)))
    return damaged("wrong values");
  const auto gaps = reader.number();
  if (!reader.ok() || gaps > count || !take_gaps(reader, points, gaps)) return damaged("wrong gaps");
  if (reader.remaining() > 0) return damaged("bytes after its end");
  return points;
}

namespace {

constexpr std::uint8_t kPlain = 0, kZstd = 1;
constexpr int kLevel = 3;

}  // namespace

BlockCodec::BlockCodec() : packer_(ZSTD_createCCtx(), ZSTD_freeCCtx), unpacker_(ZSTD_createDCtx(), ZSTD_freeDCtx) {
  RUBICON_ASSERT(packer_ && unpacker_);
  ZSTD_CCtx_setParameter(packer_.get(), ZSTD_c_compressionLevel, kLevel);
  ZSTD_CCtx_setParameter(packer_.get(), ZSTD_c_checksumFlag, 1);
}

BlockCodec::~BlockCodec() = default;

Bytes BlockCodec::close(ByteView plain) {
  Bytes out(1 + ZSTD_compressBound(plain.size()));
  const auto size = ZSTD_compress2(packer_.get(), out.data() + 1, out.size() - 1, plain.data(), plain.size());
  if (ZSTD_isError(size) == 0 && size < plain.size()) {
    out[0] = kZstd;
    out.resize(1 + size);
    return out;
  }
  out.resize(1 + plain.size());
  out[0] = kPlain;
  std::copy(plain.begin(), plain.end(), out.begin() + 1);
  return out;
}

Result<ByteView> BlockCodec::open(ByteView closed) {
  if (closed.empty() || closed[0] > kZstd) return fail(ErrorCode::kInvalid, "a block of unknown form");
  const auto rest = closed.subspan(1);
  if (closed[0] == kPlain) return rest;
  const auto length = ZSTD_getFrameContentSize(rest.data(), rest.size());
  // The two values for "unknown" and "error" are beyond it, too.
  if (length > kMaxPlain) return fail(ErrorCode::kInvalid, "a block of unknown length");
  plain_.resize(static_cast<std::size_t>(length));
  const auto size = ZSTD_decompressDCtx(unpacker_.get(), plain_.data(), plain_.size(), rest.data(), rest.size());
  if (ZSTD_isError(size) != 0 || size != plain_.size())
    return fail(ErrorCode::kInvalid, fmt::format("a damaged block of {} bytes", closed.size()));
  return ByteView(plain_);
}

Result<Points> BlockCodec::decode(ByteView bytes) {
  const auto plain = open(bytes);
  if (!plain) return fail(plain.error());
  return unpack_points(*plain);
}

namespace {

constexpr std::size_t kTail = 32;

}  // namespace

void OpenPoints::add(const Point& point) {
  start_ = empty() ? point.time : std::min(start_, point.time);
  end_ = empty() ? point.time : std::max(end_, point.time);
  last_ = point;
  ++count_;
  tail_.push_back(point);
  if (tail_.size() < kTail) return;
  auto packed = pack_points(tail_);
  packed.shrink_to_fit();
  packed_.push_back(std::move(packed));
  tail_.clear();
}

void OpenPoints::clear() {
  *this = OpenPoints();
}

Points OpenPoints::all() const {
  Points points;
  points.reserve(count_);
  for (const auto& packed : packed_) {
    const auto some = unpack_points(packed);
    RUBICON_ASSERT(some);  // we packed it
    points.insert(points.end(), some->begin(), some->end());
  }
  points.insert(points.end(), tail_.begin(), tail_.end());
  return points;
}

std::vector<Points> take_blocks(Points& points, std::size_t most) {
  std::vector<Points> blocks;
  std::size_t begin = 0;
  std::int64_t start = 0, end = 0;
  for (std::size_t i = 0; i <= points.size(); ++i) {
    if (i > begin && i < points.size()) {
      start = std::min(start, points[i].time);
      end = std::max(end, points[i].time);
    }
    const bool full = i - begin >= most || (i > begin && end - start > kOpenBlock);
    if (full) {
      blocks.emplace_back(points.begin() + static_cast<std::ptrdiff_t>(begin),
                          points.begin() + static_cast<std::ptrdiff_t>(i));
      begin = i;
    }
    if (i == begin && i < points.size()) start = end = points[i].time;
  }
  points.erase(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(begin));
  return blocks;
}

}  // namespace rubicon::history
