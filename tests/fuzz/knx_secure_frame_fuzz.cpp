#include <algorithm>
#include <cstdlib>

#include "fuzz_target.h"
#include "networks/knx/secure/frames.h"

namespace rubicon::fuzz::knx_secure_frame_fuzz {

namespace {

using namespace rubicon::networks::knx;
using namespace rubicon::networks::knx::secure;

void require(bool condition) {
  if (!condition) std::abort();
}

/// What was read is written as the same bytes but for reserved ones, so that it reads the same again.
template <class Read>
void check_body(Read read, const wire::Frame& frame) {
  const auto body = read(frame);
  if (!body) return require(!body.error().text.empty());
  const auto written = write(*body);
  const auto again = wire::read_frame(written);
  require(again && again->service == frame.service);
  const auto second = read(*again);
  require(second && write(*second) == written);
}

/// Nobody knows the key: no input may pass for a frame, and nothing of it comes out.
void check_wrapper(const wire::Frame& frame) {
  const auto wrapper = read_wrapper(frame);
  if (!wrapper) return;
  Ccm ccm;
  Bytes plain;
  const auto opened = open_wrapper(ccm, Key(), *wrapper, plain);
  require(opened.has_value());
  require(plain.empty() == (*opened != Opened::kFrame));
}

/// Every frame survives its wrapper, unless no wrapper may hold it.
void check_content(ByteView content) {
  if (content.size() > 2000) return;
  Ccm ccm;
  Bytes wrapped, plain;
  require(seal_wrapper(ccm, Key(), {1, 2, {}, 3}, content, wrapped).has_value());
  const auto wrapper = read_wrapper(wire::read_frame(wrapped).value());
  const auto opened = open_wrapper(ccm, Key(), wrapper.value(), plain);
  require(opened && *opened != Opened::kWrongMac);
  if (*opened == Opened::kFrame) require(std::equal(plain.begin(), plain.end(), content.begin(), content.end()));
}

}  // namespace

/// Input: a frame.
FUZZ_TARGET(knx_secure_frame) {
  const ByteView bytes(data, size);
  check_content(bytes);
  const auto frame = wire::read_frame(bytes);
  if (!frame) return 0;
  using wire::ServiceCode;
  switch (frame->service) {
    case ServiceCode::kSecureWrapper: check_wrapper(*frame); break;
    case ServiceCode::kSessionRequest: check_body(read_session_request, *frame); break;
    case ServiceCode::kSessionResponse: check_body(read_session_response, *frame); break;
    case ServiceCode::kSessionAuthenticate: check_body(read_session_authenticate, *frame); break;
    case ServiceCode::kSessionStatus: check_body(read_session_status, *frame); break;
    case ServiceCode::kTimerNotify: check_body(read_timer_notify, *frame); break;
    default: break;
  }
  return 0;
}

}  // namespace rubicon::fuzz::knx_secure_frame_fuzz
