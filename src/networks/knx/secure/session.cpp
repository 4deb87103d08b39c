#include "networks/knx/secure/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/assert.h"
#include "model/findings.h"
#include "networks/knx/secure/session_channel.h"

namespace rubicon::networks::knx::secure {

namespace {

using namespace std::chrono_literals;
using wire::ServiceCode;

// knx.md, section 5.1.
constexpr Duration kHandshakeTime = 10s;
/// The server ends a session that is silent for 60 s. Over UDP two of three keep-alives may get lost.
constexpr Duration kKeepAlive = 50s, kKeepAliveUdp = 15s;
/// Interval of requests over UDP, so that one lost datagram does not cost 10 s.
constexpr Duration kRepeat = 2s;

/// A wrapper of the server does not hold what only a client sends, or what begins a session.
bool of_server(ServiceCode service) {
  return service != ServiceCode::kSessionRequest && service != ServiceCode::kSessionResponse &&
         service != ServiceCode::kSessionAuthenticate && service != ServiceCode::kTimerNotify;
}

}  // namespace

Session::Session(Scheduler& scheduler, const SessionKeys& keys, Settings settings, SessionCounters& counters,
                 Callbacks callbacks)
    : scheduler_(scheduler),
      keys_(keys),
      settings_(std::move(settings)),
      counters_(counters),
      callbacks_(std::move(callbacks)),
      deadline_(scheduler, [this] { due(); }) {}

void Session::start() {
  RUBICON_ASSERT(phase_ == Phase::kNew);
  phase_ = Phase::kRequested;
  until_ = scheduler_.now() + kHandshakeTime;
  auto pair = KeyPair::make(settings_.random);
  if (!pair) return end(Cause::kBroken, pair.error().text);
  pair_ = std::move(*pair);
  own_public_ = pair_->public_key();
  send_request();
}

// To the server.

void Session::send_request() {
  deadline_.set_at(settings_.repeats ? std::min(scheduler_.now() + kRepeat, until_) : until_);
  callbacks_.transmit(write(SessionRequest{settings_.own, own_public_}));
}

void Session::repeat() {
  if (scheduler_.now() < until_) {
    if (phase_ == Phase::kAuthenticating) return send_authenticate();
    if (settings_.tries_route_back) settings_.own = {};
    return send_request();
  }
  if (rejected_) return end(rejected_->cause, std::move(rejected_->why));
  const bool unanswered = phase_ == Phase::kRequested;
  end(Cause::kNoAnswer, unanswered ? "the interface does not answer the request for a secure session (does it support "
                                     "KNX IP Secure?)"
                                   : "the interface does not answer the authentication of the secure session");
}

const Key& Session::user_key() const {
  return keys_.user_key.form(settings_.password_form);
}

void Session::send_authenticate() {
  deadline_.set_at(settings_.repeats ? std::min(scheduler_.now() + kRepeat, until_) : until_);
  const auto mac = authenticate_mac(ccm_, user_key(), keys_.user, own_public_, server_public_);
  if (!mac) return end(Cause::kBroken, mac.error().text);
  if (!wrap(write(SessionAuthenticate{keys_.user, *mac}))) end(Cause::kBroken, "a frame could not be encrypted");
}

bool Session::wrap(ByteView frame) {
  const auto sealed = channel_->seal(ccm_, frame);
  if (!sealed) return false;
  callbacks_.transmit(*sealed);
  return true;
}

void Session::send(ByteView frame) {
  RUBICON_ASSERT(up());
  deadline_.set(keep_alive_pause());
  static_cast<void>(wrap(frame));  // as if it were lost: the tunnel has timers for that
}

Duration Session::keep_alive_pause() const {
  return settings_.repeats ? kKeepAliveUdp : kKeepAlive;
}

void Session::due() {
  if (up()) return keep_alive();
  repeat();
}

void Session::keep_alive() {
  send(write(Status::kKeepAlive));
}

void Session::close() {
  if (channel_ && (phase_ == Phase::kUp || phase_ == Phase::kAuthenticating))
    static_cast<void>(wrap(write(Status::kClose)));
  stop();
}

// From the server.

void Session::receive(ByteView bytes) {
  if (phase_ == Phase::kEnded || phase_ == Phase::kNew) return;
  const auto frame = wire::read_frame(bytes);
  if (!frame) return drop(counters_.bad_frames, "bad-frames", frame.error().text);
  if (frame->service == ServiceCode::kSecureWrapper) return receive_wrapper(*frame);
  if (frame->service == ServiceCode::kSessionResponse && phase_ == Phase::kRequested) return receive_response(*frame);
  drop(counters_.plain_frames, "secure-plain-frames",
       fmt::format("the interface sent {} unencrypted: ignored", to_string(frame->service)));
}

void Session::drop(std::uint64_t& counter, const char* subject, std::string_view text) {
  ++counter;
  if (callbacks_.note) callbacks_.note(subject, text);
}

void Session::receive_response(const wire::Frame& frame) {
  const auto response = read_session_response(frame);
  if (!response) return drop(counters_.bad_frames, "bad-frames", response.error().text);
  if (response->session == 0)
    return reject_response(Cause::kNoneFree, "all secure sessions of the interface are in use (session 0)");
  server_public_ = response->public_key;
  const auto verified = verify(*response);
  if (!verified) return end(Cause::kBroken, verified.error().text);
  if (!*verified && keys_.device_code)
    return reject_response(
        Cause::kWrongServer,
        "the interface is not the device that the configuration names, or the device password (authentication "
        "code) is wrong: its proof of identity does not match");
  verified_ = *verified;
  if (auto agreed = agree(*response); !agreed) return reject_response(Cause::kBroken, agreed.error().text);
  rejected_.reset();
  phase_ = Phase::kAuthenticating;
  send_authenticate();
}

/// Over UDP the right response may still come.
void Session::reject_response(Cause cause, const std::string& why) {
  if (!settings_.repeats) return end(cause, why);
  rejected_ = End{cause, 0, why};
  if (cause == Cause::kWrongServer) return drop(counters_.wrong_mac, "secure-wrong-mac", why);
  if (cause == Cause::kBroken) drop(counters_.bad_frames, "bad-frames", why);
}

/// True if the server knows the device authentication code, in one of the forms that its password has.
Result<bool> Session::verify(const SessionResponse& response) {
  if (!keys_.device_code) return false;
  const auto matches = [&](const Key& code) -> Result<bool> {
    const auto mac = response_mac(ccm_, code, response.session, own_public_, server_public_);
    if (!mac) return fail(mac.error());
    return equal(*mac, response.mac);
  };
  auto matched = matches(keys_.device_code->key);
  for (std::size_t form = 1; matched && !*matched && form < keys_.device_code->forms(); ++form)
    matched = matches(keys_.device_code->form(form));
  return matched;
}

Result<void> Session::agree(const SessionResponse& response) {
  const auto shared = pair_->shared_with(server_public_);
  if (!shared) return fail(shared.error());
  auto key = session_key(*shared);
  if (!key) return fail(key.error());
  Serial serial{};
  if (auto filled = settings_.random(serial); !filled) return filled;
  channel_.emplace(response.session, std::move(*key), serial);
  pair_.reset();
  return {};
}

void Session::receive_wrapper(const wire::Frame& frame) {
  const auto wrapper = read_wrapper(frame);
  if (!wrapper) return drop(counters_.bad_frames, "bad-frames", wrapper.error().text);
  if (!channel_) return receive_opened(SessionChannel::Verdict::kOtherSession);
  const auto verdict = channel_->open(ccm_, *wrapper);
  if (!verdict) return end(Cause::kBroken, verdict.error().text);
  receive_opened(*verdict);
}

void Session::receive_opened(SessionChannel::Verdict verdict) {
  using Verdict = SessionChannel::Verdict;
  if (verdict != Verdict::kFrame) return drop_opened(verdict);
  const auto frame = wire::read_frame(channel_->opened());
  if (!frame || !of_server(frame->service)) return drop_opened(Verdict::kForbidden);
  if (frame->service == ServiceCode::kSessionStatus) return receive_status(*frame);
  if (phase_ == Phase::kUp) return callbacks_.received(channel_->opened());
  drop(counters_.early_frames, "secure-early-frames",
       fmt::format("the interface sent {} before the session was authenticated: ignored", to_string(frame->service)));
}

void Session::drop_opened(SessionChannel::Verdict verdict) {
  using Verdict = SessionChannel::Verdict;
  switch (verdict) {
    case Verdict::kOtherSession:
      return drop(counters_.other_sessions, "secure-other-sessions",
                  "the interface sent a frame of another secure session: ignored");
    case Verdict::kReflected:
      return drop(counters_.replays, "secure-replays", "a frame of ours came back from the interface: ignored");
    case Verdict::kReplayed:
      return drop(counters_.replays, "secure-replays",
                  "a frame with an old sequence number came from the interface (a replay?): ignored");
    case Verdict::kWrongMac:
      return drop(counters_.wrong_mac, "secure-wrong-mac",
                  "a frame that was changed or has another key came from the interface: ignored");
    case Verdict::kForbidden:
      return drop(counters_.forbidden_frames, "secure-forbidden-frames",
                  "the interface wrapped what no wrapper may hold: ignored");
    case Verdict::kFrame: return;
  }
}

void Session::receive_status(const wire::Frame& frame) {
  const auto status = read_session_status(frame);
  if (!status) return drop(counters_.bad_frames, "bad-frames", status.error().text);
  switch (*status) {
    case Status::kAuthenticated: return authenticated();
    case Status::kAuthenticationFailed:
    case Status::kUnauthenticated: return refused(*status);
    case Status::kTimeout:
      return end(Cause::kClosed,
                 "the interface ended the secure session, because it received nothing (session status 3)", 3);
    case Status::kClose: return end(Cause::kClosed, "the interface closed the secure session (session status 5)", 5);
    case Status::kKeepAlive: return;
  }
  drop(counters_.bad_frames, "bad-frames",
       fmt::format("the interface sent the unknown session status {}: ignored", static_cast<unsigned>(*status)));
}

void Session::authenticated() {
  if (phase_ != Phase::kAuthenticating) return;  // the answer to a repeated request
  phase_ = Phase::kUp;
  ++counters_.sessions;
  if (!verified_) ++counters_.unverified;
  deadline_.set(keep_alive_pause());
  callbacks_.up();
}

/// Servers answer 1 or 2 to a wrong user as well as to a wrong password (knx.md, section 21.1).
void Session::refused(Status status) {
  const auto number = static_cast<std::uint8_t>(status);
  if (phase_ == Phase::kUp)
    return end(Cause::kForgotten,
               fmt::format("the interface no longer accepts the secure session (session status {})", number), number);
  static_cast<void>(wrap(write(Status::kClose)));
  end(Cause::kNotAuthenticated,
      fmt::format("the interface does not accept user {} with this password: the user number or the user password is "
                  "wrong (session status {})",
                  keys_.user, number),
      number);
}

void Session::stop() {
  phase_ = Phase::kEnded;
  deadline_.clear();
  channel_.reset();
  pair_.reset();
}

std::string_view Session::End::finding() const {
  switch (cause) {
    case Cause::kNoneFree: return model::findings::kSessionsInUse;
    case Cause::kWrongServer: return model::findings::kWrongInterface;
    case Cause::kNotAuthenticated: return model::findings::kUserRefused;
    case Cause::kNoAnswer: return model::findings::kSessionUnanswered;
    case Cause::kClosed:
    case Cause::kForgotten:
    case Cause::kBroken: break;
  }
  return {};
}

void Session::end(Cause cause, std::string why, std::uint8_t status) {
  stop();
  callbacks_.ended({cause, status, std::move(why)});
}

}  // namespace rubicon::networks::knx::secure
