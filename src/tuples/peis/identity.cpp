#include "tuples/peis/identity.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "rubicon/summary.hpp"
#include "tuples/peis/wire.h"

namespace rubicon::tuples::peis {

namespace {

using namespace std::chrono_literals;

constexpr std::string_view kMark = "RBC1";
constexpr Duration kShortestLease = 500ms, kLongestLease = 60s;

}  // namespace

Bytes encode(const Hello& hello) {
  base::ByteWriter out;
  const auto lease = std::chrono::floor<std::chrono::milliseconds>(hello.lease).count();
  out.bytes(base::as_bytes(kMark)).u16_be(hello.version).u32_be(static_cast<std::uint32_t>(lease));
  out.u64_be(hello.incarnation)
      .bytes(base::as_bytes(hello.host_id).first(std::min(hello.host_id.size(), Hello::kMaxHostId)));
  return out.take();
}

Result<Hello> decode_hello(ByteView body) {
  base::ByteReader in(body);
  const auto mark = base::as_text(in.take(kMark.size()));
  Hello hello;
  hello.version = in.u16_be();
  const auto lease = std::chrono::milliseconds(in.u32_be());
  hello.incarnation = in.u64_be();
  if (!in.ok() || mark != kMark || hello.version == 0) return fail(ErrorCode::kInvalid, "hello: no mark, or too short");
  const auto rest = base::as_text(in.take(in.remaining()));
  hello.host_id = rest.substr(0, std::min(rest.find('\0'), Hello::kMaxHostId));
  hello.lease = std::clamp<Duration>(lease, kShortestLease, kLongestLease);
  return hello;
}

std::string kernel_summary(const Identity& host) {
  Summary summary;
  summary.name = host.full_name.substr(0, host.full_name.find('@'));
  summary.host = host.host_name;
  summary.program = fmt::format("peis-kernel {}", kProtocolVersion);
  return model::to_json(summary);
}

}  // namespace rubicon::tuples::peis
