#include "tuples/mqtt/messages.h"

#include <fmt/format.h>
#include <zstd.h>

#include "base/assert.h"

namespace rubicon::tuples::mqtt {

namespace {

using distant::FieldReader;
using distant::FieldWriter;

constexpr std::size_t kMaxHost = 64;
constexpr std::uint64_t kMaxLeaseMs = 24ULL * 3600 * 1000;
constexpr std::uint8_t kAgain = 1;

std::string text_of(FieldWriter& fields) {
  return std::string(base::as_text(fields.view()));
}

Error malformed(std::string_view what) {
  return {ErrorCode::kInvalid, fmt::format("{}: malformed", what)};
}

Result<void> check_version(FieldReader& in, std::string_view what) {
  const auto version = in.byte();
  if (!in.ok()) return fail(malformed(what));
  if (version == kProtocolVersion) return {};
  return fail(ErrorCode::kUnsupported, fmt::format("{} of version {} of the protocol, this program has version {}",
                                                   what, version, kProtocolVersion));
}

}  // namespace

std::string line_text(const LineShown& shown) {
  FieldWriter out;
  out.byte(kProtocolVersion);
  out.number(shown.count);
  out.number(static_cast<std::uint64_t>(shown.lease / std::chrono::milliseconds(1)));
  return text_of(out);
}

Result<LineShown> read_line(std::string_view payload) {
  FieldReader in(base::as_bytes(payload));
  if (auto good = check_version(in, "a connection"); !good) return fail(std::move(good.error()));
  LineShown shown;
  shown.count = in.number();
  const auto lease = in.number();
  if (!in.ok() || !in.at_end() || lease == 0 || lease > kMaxLeaseMs) return fail(malformed("a connection"));
  shown.lease = std::chrono::milliseconds(lease);
  return shown;
}

std::string component_text(const ComponentShown& shown) {
  FieldWriter out;
  out.byte(kProtocolVersion);
  out.number(shown.incarnation);
  out.text(shown.host);
  out.text(shown.summary);
  return text_of(out);
}

Result<ComponentShown> read_component(std::string_view payload) {
  FieldReader in(base::as_bytes(payload));
  if (auto good = check_version(in, "a component"); !good) return fail(std::move(good.error()));
  ComponentShown shown;
  shown.incarnation = in.number();
  shown.host = in.text();
  shown.summary = in.text();
  const bool fits = shown.incarnation != 0 && shown.host.size() <= kMaxHost && shown.summary.size() <= kMaxSummary;
  if (!in.ok() || !in.at_end() || !fits) return fail(malformed("a component"));
  return shown;
}

Bytes frame_of(const FrameHead& head, ByteView entries) {
  FieldWriter out;
  out.byte(kProtocolVersion);
  for (const auto value : {std::uint64_t{number(head.source)}, head.source_incarnation,
                           std::uint64_t{number(head.target)}, head.target_incarnation, head.stream, head.number,
                           head.first, head.heard_stream, head.heard, std::uint64_t{head.credit}})
    out.number(value);
  out.byte(head.again ? kAgain : 0);
  out.bytes(entries);
  return out.take();
}

Result<FrameHead> read_head(ByteView frame, ByteView& entries) {
  FieldReader in(frame);
  if (auto good = check_version(in, "a frame"); !good) return fail(std::move(good.error()));
  FrameHead head;
  head.source = in.owner();
  head.source_incarnation = in.number();
  head.target = in.owner();
  head.target_incarnation = in.number();
  for (auto* value : {&head.stream, &head.number, &head.first, &head.heard_stream, &head.heard}) *value = in.number();
  const auto credit = in.number();
  head.credit = static_cast<std::uint32_t>(credit);
  head.again = (in.byte() & kAgain) != 0;
  if (!in.ok() || credit > 0xffff || head.first > head.number) return fail(malformed("a frame"));
  entries = in.rest();
  return head;
}

namespace {

/// The first byte of ZSTD_MAGICNUMBER as it is sent (RFC 8878, 3.1.1).
constexpr std::uint8_t kFirstByte = ZSTD_MAGICNUMBER & 0xff;
/// For a message that is sent once, time matters more than the last tenth of its size.
constexpr int kFastest = 1;

}  // namespace

Packing::Packing() : packer_(ZSTD_createCCtx(), ZSTD_freeCCtx), unpacker_(ZSTD_createDCtx(), ZSTD_freeDCtx) {
  RUBICON_ASSERT(packer_ && unpacker_);
}

Packing::~Packing() = default;

std::optional<Bytes> Packing::packed(ByteView entries) {
  if (entries.size() < kMinPacked || entries.size() > kMaxUnpacked) return std::nullopt;
  Bytes out(ZSTD_compressBound(entries.size()));
  const auto size = ZSTD_compressCCtx(packer_.get(), out.data(), out.size(), entries.data(), entries.size(), kFastest);
  if (ZSTD_isError(size) != 0 || size >= entries.size()) return std::nullopt;
  out.resize(size);
  return out;
}

Result<ByteView> Packing::unpacked(ByteView received, Bytes& into) {
  if (received.empty() || received[0] != kFirstByte) return received;
  const auto length = ZSTD_getFrameContentSize(received.data(), received.size());
  // The two values for "unknown" and "error" are beyond it, too.
  if (length > kMaxUnpacked) return fail(ErrorCode::kInvalid, "packed entries of unknown or excessive size");
  into.resize(static_cast<std::size_t>(length));
  const auto size = ZSTD_decompressDCtx(unpacker_.get(), into.data(), into.size(), received.data(), received.size());
  if (ZSTD_isError(size) != 0 || size != into.size())
    return fail(ErrorCode::kInvalid, fmt::format("{} bytes of packed entries are damaged", received.size()));
  return ByteView(into);
}

}  // namespace rubicon::tuples::mqtt
