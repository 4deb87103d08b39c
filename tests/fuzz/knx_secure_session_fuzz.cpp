#include <algorithm>
#include <cstdlib>
#include <memory>

#include "base/virtual_scheduler.h"
#include "fuzz_target.h"
#include "networks/knx/secure/session.h"
#include "networks/knx/secure/session_channel.h"

namespace rubicon::fuzz::knx_secure_session_fuzz {

namespace {

using namespace rubicon::networks::knx;
using namespace rubicon::networks::knx::secure;

/// The random bytes of both ends: 00 01 02 ...
Result<void> count_up(std::span<std::uint8_t> bytes) {
  std::uint8_t next = 0;
  for (auto& byte : bytes) byte = next++;
  return {};
}

SessionKeys keys() {
  SessionKeys made;
  made.device_code = PasswordKey{};
  return made;
}

/// A server that knows all keys, so that the input reaches what lies behind the MACs.
class Server {
 public:
  Server() : pair_(KeyPair::make(count_up).value()), key_(session_key(*pair_.shared_with(pair_.public_key())).value()) {
    channel_ = std::make_unique<SessionChannel>(1, key_, Serial{9});
  }
  Bytes response() {
    const auto& own = pair_.public_key();
    return write(SessionResponse{1, own, response_mac(ccm_, Key(), 1, own, own).value()});
  }
  Bytes wrap(ByteView frame) {
    const auto sealed = channel_->seal(ccm_, frame).value();
    return {sealed.begin(), sealed.end()};
  }

 private:
  Ccm ccm_;
  KeyPair pair_;
  Key key_;
  std::unique_ptr<SessionChannel> channel_;
};

}  // namespace

/// Input: events for a client whose request was sent: a length byte and a frame of it as it is; 255 moves time, 254
/// answers the request, 253 and a length byte and a frame: the same wrapped, 252 sends a frame. Nothing that a server
/// sends may do harm.
FUZZ_TARGET(knx_secure_session) {
  VirtualScheduler time;
  const auto client_keys = keys();
  SessionCounters counters;
  Server server;
  bool ended = false, up = false;
  Session::Callbacks calls;
  calls.transmit = [&](ByteView frame) {
    const auto sent = wire::read_frame(frame);
    if (ended || !sent) std::abort();
    // Nothing but the request leaves unencrypted.
    if (sent->service != wire::ServiceCode::kSessionRequest && sent->service != wire::ServiceCode::kSecureWrapper)
      std::abort();
  };
  calls.up = [&] { up = true; };
  calls.received = [&](ByteView frame) {
    if (!up || ended || !wire::read_frame(frame)) std::abort();
  };
  calls.note = [](const std::string& subject, std::string_view text) {
    if (subject.empty() || text.empty()) std::abort();
  };
  calls.ended = [&](const Session::End& end) {
    if (ended || end.why.empty()) std::abort();
    ended = true;
  };
  Session::Settings settings;
  settings.random = count_up;
  Session session(time, client_keys, settings, counters, std::move(calls));
  session.start();
  for (std::size_t at = 0; at < size;) {
    const std::size_t event = data[at++];
    if (event == 255) {
      time.run_for(std::chrono::seconds(7));
    } else if (event == 254) {
      session.receive(server.response());
    } else if (event == 252) {
      if (session.up()) session.send(write(Status::kKeepAlive));
    } else {
      const bool wrapped = event == 253;
      const std::size_t length = !wrapped ? event : at < size ? data[at++] : 0;
      const ByteView frame(data + at, std::min(length, size - at));
      at += frame.size();
      wrapped ? session.receive(server.wrap(frame)) : session.receive(frame);
    }
    if (ended && session.up()) std::abort();
  }
  session.close();
  time.run_for(std::chrono::minutes(5));
  return 0;
}

}  // namespace rubicon::fuzz::knx_secure_session_fuzz
