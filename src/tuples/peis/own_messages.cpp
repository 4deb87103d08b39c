#include "tuples/peis/own_messages.h"

#include "tuples/peis/fields.h"
#include "tuples/peis/tuple_wire.h"

namespace rubicon::tuples::peis {

namespace {

constexpr std::size_t kReplySize = 22, kControlSize = 8;
constexpr std::uint8_t kSnapshotEnd = 1, kRestart = 2, kForget = 3;

Bytes marked_body(std::size_t size) {
  Bytes out(size);
  put_bytes(out, 0, kAnnexMark);
  return out;
}

Result<void> check_mark(std::string_view body, ByteView bytes, std::size_t size) {
  if (bytes.size() < size) return wrong_field(body, fmt::format("{} bytes, expected at least {}", bytes.size(), size));
  if (!std::equal(kAnnexMark.begin(), kAnnexMark.end(), bytes.begin()))
    return wrong_field(body, "another mark, expected RBC1");
  return {};
}

}  // namespace

Bytes write_reply(const Reply& reply) {
  auto out = marked_body(kReplySize);
  put_u64(out, 4, reply.request);
  put_u64(out, 12, reply.sequence);
  out[20] = static_cast<std::uint8_t>(reply.verdict);
  out[21] = static_cast<std::uint8_t>(reply.code);
  out.insert(out.end(), reply.text.begin(), reply.text.end());
  return out;
}

Result<Reply> read_reply(ByteView body) {
  constexpr std::string_view kBody = "REPLY";
  if (const auto good = check_mark(kBody, body, kReplySize); !good) return fail(good.error());
  if (body[20] > static_cast<std::uint8_t>(Verdict::kNoSuchOwner))
    return wrong_field(kBody, fmt::format("verdict at 20: {}, expected at most 3", body[20]));
  if (body[21] > static_cast<std::uint8_t>(ErrorCode::kIo))
    return wrong_field(kBody, fmt::format("error code at 21: {}, expected at most 9", body[21]));
  Reply reply;
  reply.request = u64_at(body, 4);
  reply.sequence = u64_at(body, 12);
  reply.verdict = Verdict(body[20]);
  reply.code = ErrorCode(body[21]);
  reply.text = base::as_text(body.subspan(kReplySize));
  return reply;
}

Bytes write_control(const SnapshotEnd& end) {
  auto out = marked_body(kControlSize + 4);
  out[4] = kSnapshotEnd;
  put_u32(out, kControlSize, end.subscription);
  return out;
}

Bytes write_control(const Restart& restart) {
  auto out = marked_body(kControlSize + 8);
  out[4] = kRestart;
  put_u64(out, kControlSize, static_cast<std::uint64_t>(restart.since.time_since_epoch().count()));
  return out;
}

Bytes write_forget() {
  auto out = marked_body(kControlSize);
  out[4] = kForget;
  return out;
}

bool is_forget(ByteView body) {
  return check_mark("SNAPSHOT", body, kControlSize) && body.size() == kControlSize && body[4] == kForget;
}

Result<Change> read_control(ByteView body) {
  constexpr std::string_view kBody = "SNAPSHOT";
  if (const auto good = check_mark(kBody, body, kControlSize); !good) return fail(good.error());
  const bool is_end = body[4] == kSnapshotEnd;
  if (!is_end && body[4] != kRestart) return wrong_field(kBody, fmt::format("kind at 4: {}, expected 1 or 2", body[4]));
  if (const auto size = expect_size(kBody, body, kControlSize + (is_end ? 4 : 8)); !size) return fail(size.error());
  if (is_end) return SnapshotEnd{u32_at(body, kControlSize)};
  const auto since = static_cast<std::int64_t>(u64_at(body, kControlSize));
  return Restart{WallTime(std::chrono::microseconds(since))};
}

}  // namespace rubicon::tuples::peis
