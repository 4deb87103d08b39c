#include "apps/simulators/knx/secure_sessions.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "apps/simulators/knx/server.h"
#include "base/text.h"
#include "networks/knx/secure/passwords.h"
#include "networks/knx/secure/session_channel.h"
#include "networks/knx/wire/address.h"
#include "networks/knx/wire/blocks.h"

namespace rubicon::knx_simulator {

using namespace networks::knx::secure;
using networks::knx::wire::Frame;
using networks::knx::wire::ServiceCode;

namespace {

std::string_view take_word(std::string_view& line) {
  const auto end = std::min(line.find(' '), line.size());
  const auto word = line.substr(0, end);
  line.remove_prefix(std::min(end + 1, line.size()));
  return word;
}

Result<void> read_user(std::string_view rest, SecureOptions& options) {
  SecureUser user;
  const auto number = base::parse_number<std::uint8_t>(take_word(rest));
  if (!number || *number < 1 || *number > 127) return fail(ErrorCode::kInvalid, "expected a user number from 1 to 127");
  user.number = *number;
  const auto address = take_word(rest);
  if (address != "any") {
    const auto parsed = networks::knx::wire::parse_individual(address);
    // The error of the parser would show the word, which may be of a password.
    if (!parsed)
      return fail(ErrorCode::kInvalid, "expected `any` or an address such as 1.1.200 behind the user number");
    user.address = networks::knx::wire::number(*parsed);
  }
  const auto keys = user_key(Secret::of_text(rest));
  if (!keys) return fail(keys.error());
  user.key = keys->key;
  options.users.push_back(std::move(user));
  return {};
}

Result<void> read_line(std::string_view line, SecureOptions& options) {
  const auto word = take_word(line);
  if (word.empty() || word.starts_with('#')) return {};
  if (word == "user") return read_user(line, options);
  if (word != "device-password")
    return fail(ErrorCode::kInvalid, "expected `device-password TEXT` or `user NUMBER any|ADDRESS TEXT`");
  const auto code = device_code(Secret::of_text(line));
  if (!code) return fail(code.error());
  options.device_code = code->key;
  return {};
}

}  // namespace

Result<SecureOptions> parse_secure_options(std::string_view text) {
  SecureOptions options;
  for (int line = 1; !text.empty(); ++line) {
    const auto end = std::min(text.find('\n'), text.size());
    if (auto read = read_line(text.substr(0, end), options); !read)
      return fail(ErrorCode::kInvalid, fmt::format("line {}: {}", line, read.error().text));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  if (options.users.empty()) return fail(ErrorCode::kInvalid, "expected a line `user NUMBER any|ADDRESS TEXT`");
  return options;
}

SecureSessions::SecureSessions(Scheduler& scheduler, SecureOptions options, std::function<void(std::uint16_t)> ended)
    : scheduler_(scheduler), options_(std::move(options)), ended_(std::move(ended)) {}

// The handshake.

void SecureSessions::request(const Frame& frame, Reply reply, const void* connection) {
  ++counters.requests;
  const auto request = read_session_request(frame);
  if (!request || !answers_requests) return;
  if (sessions_.size() >= options_.sessions) return refuse(reply);
  if (!agree(request->public_key, reply, connection)) refuse(reply);
}

void SecureSessions::refuse(const Reply& reply) const {
  const auto frame = write(SessionResponse{});
  reply(frame);
}

Result<void> SecureSessions::agree(const PublicKey& client, Reply reply, const void* connection) {
  const auto pair = KeyPair::make(options_.random);
  if (!pair) return fail(pair.error());
  const auto shared = pair->shared_with(client);
  if (!shared) return fail(shared.error());
  auto key = session_key(*shared);
  Serial serial{};
  if (auto filled = options_.random(serial); !filled || !key) return fail(ErrorCode::kIo, "no session key");
  do {
    ++last_id_;
  } while (last_id_ == 0 || sessions_.contains(last_id_));
  const auto id = last_id_;
  const auto& code = other_device_code ? *other_device_code : options_.device_code;
  const auto mac = response_mac(ccm_, code, id, client, pair->public_key());
  if (!mac) return fail(mac.error());
  const auto session = std::make_shared<Session>(SessionChannel(id, std::move(*key), serial), scheduler_, [this, id] {
    ++counters.timeouts;
    end(id, Status::kTimeout);
  });
  session->client = client;
  session->server = pair->public_key();
  session->reply = std::move(reply);
  session->connection = connection;
  session->silence.set(unauthenticated);
  sessions_[id] = session;
  const auto frame = write(SessionResponse{id, pair->public_key(), *mac});
  session->reply(frame);
  return {};
}

bool SecureSessions::proves(Session& session, const SecureUser& user, const Block& mac) {
  const auto expected = authenticate_mac(ccm_, user.key, user.number, session.client, session.server);
  return expected && equal(*expected, mac);
}

void SecureSessions::authenticate(std::uint16_t id, Session& session, const Frame& frame) {
  const auto asked = read_session_authenticate(frame);
  if (!asked || !answers_authentication) return;
  const auto user = std::find_if(options_.users.begin(), options_.users.end(),
                                 [&](const SecureUser& one) { return one.number == asked->user; });
  const bool known = user != options_.users.end();
  if (!known || !proves(session, *user, asked->mac)) {
    ++counters.refused;
    return end(id, known ? Status::kAuthenticationFailed : Status(unknown_user_status));
  }
  counters.authenticated += session.user == nullptr ? 1 : 0;
  session.user = &*user;
  session.silence.set(silence);
  tell(session, Status::kAuthenticated);
}

// Frames.

bool SecureSessions::count(SessionChannel::Verdict verdict) {
  using Verdict = SessionChannel::Verdict;
  if (verdict == Verdict::kReplayed || verdict == Verdict::kReflected) ++counters.replays;
  if (verdict == Verdict::kWrongMac) ++counters.wrong_mac;
  if (verdict == Verdict::kForbidden) ++counters.forbidden;
  return verdict == Verdict::kFrame;
}

std::optional<SecureSessions::Opened> SecureSessions::unwrap(const Frame& frame) {
  const auto wrapper = read_wrapper(frame);
  const auto found = wrapper ? sessions_.find(wrapper->head.session) : sessions_.end();
  if (found == sessions_.end()) {
    ++counters.other_sessions;
    return {};
  }
  const auto id = found->first;
  const auto session = found->second;  // kept while it is used: it may end itself
  const auto verdict = session->channel.open(ccm_, *wrapper);
  if (!verdict || !count(*verdict)) return {};
  if (session->user != nullptr) session->silence.set(silence);
  const Bytes plain(session->channel.opened().begin(), session->channel.opened().end());
  const auto inner = networks::knx::wire::read_frame(plain);
  const bool of_session =
      inner->service == ServiceCode::kSessionAuthenticate || inner->service == ServiceCode::kSessionStatus;
  if (!of_session && session->user != nullptr) return Opened{id, plain};
  take(id, *session, *inner);
  return {};
}

/// What concerns the session itself, and everything before it is authenticated.
void SecureSessions::take(std::uint16_t id, Session& session, const Frame& frame) {
  if (frame.service == ServiceCode::kSessionAuthenticate) return authenticate(id, session, frame);
  const auto status = frame.service == ServiceCode::kSessionStatus ? read_session_status(frame)
                                                                   : Result<Status>(Status::kUnauthenticated);
  if (status && *status == Status::kClose) {
    ++counters.closes;
    return end(id, {});
  }
  if (session.user == nullptr) return end(id, Status::kUnauthenticated);
  if (status && *status == Status::kKeepAlive) ++counters.keep_alives;
}

Bytes SecureSessions::wrap(std::uint16_t id, ByteView frame) {
  const auto found = sessions_.find(id);
  if (found == sessions_.end()) return {};
  const auto sealed = found->second->channel.seal(ccm_, frame);
  return sealed ? Bytes(sealed->begin(), sealed->end()) : Bytes();
}

const SecureUser* SecureSessions::user_of(std::uint16_t session) const {
  const auto found = sessions_.find(session);
  return found == sessions_.end() ? nullptr : found->second->user;
}

void SecureSessions::tell(Session& session, Status status) {
  const auto frame = write(status);
  const auto sealed = session.channel.seal(ccm_, frame);
  if (sealed) session.reply(*sealed);
}

void SecureSessions::end(std::uint16_t id, std::optional<Status> status) {
  const auto node = sessions_.extract(id);
  if (!node) return;
  if (status) tell(*node.mapped(), *status);
  ended_(id);
}

void SecureSessions::lose(const void* connection) {
  std::vector<std::uint16_t> lost;
  for (const auto& [id, session] : sessions_) {
    if (session->connection == connection) lost.push_back(id);
  }
  for (const auto id : lost) end(id, {});
}

void SecureSessions::end_all(std::optional<Status> status) {
  while (!sessions_.empty()) end(sessions_.begin()->first, status);
}

// The part of the server that concerns KNX IP Secure.

using namespace networks::knx::wire;

Result<void> check_users(const ServerOptions& options) {
  if (!options.secure) return {};
  const auto text = [](std::size_t address) {
    return to_string(IndividualAddress(static_cast<std::uint16_t>(address)));
  };
  for (const auto& user : options.secure->users) {
    if (user.address == 0 || options.is_tunnel(user.address)) continue;
    return fail(ErrorCode::kInvalid,
                fmt::format("user {} has the tunnel {}, expected one from {} to {}", user.number, text(user.address),
                            text(options.first_address), text(options.first_address + options.tunnels - 1)));
  }
  return {};
}

/// True if the frame was one of the secure services.
bool Server::takes_secure(const Peer& from, ByteView bytes) {
  const auto frame = read_frame(bytes);
  if (!sessions_ || !frame) return false;
  if (frame->service == ServiceCode::kSessionRequest) {
    base::ByteReader reader(frame->body);
    const auto control = read_hpai(reader);
    if (!control) return true;
    const auto to = peer_of(from, *control);
    const auto connection = from.tcp.lock();
    sessions_->request(
        *frame,
        [this, to](ByteView reply) {
          transmit_wire(to, {reply.begin(), reply.end()}, false);
        },
        connection.get());
    return true;
  }
  if (frame->service != ServiceCode::kSecureWrapper) return false;
  const auto opened = sessions_->unwrap(*frame);
  if (!opened) return true;
  auto peer = from;
  peer.session = opened->session;
  received_plain(peer, opened->frame);
  return true;
}

/// Where sessions are required, only discovery is plain (knx.md, section 10.2).
bool Server::refuses_plain(const Peer& from, ByteView bytes) {
  const auto frame = read_frame(bytes);
  if (!sessions_ || !sessions_->options().required || !frame) return false;
  switch (frame->service) {
    case ServiceCode::kSearchRequest:
    case ServiceCode::kSearchRequestExtended:
    case ServiceCode::kDescriptionRequest: return false;
    case ServiceCode::kConnectRequest: refuse_connect(from, bytes, status::kConnectionType); break;
    default: break;
  }
  ++counters.plain_frames;
  return true;
}

/// A tunnel that only another user gets.
bool Server::is_reserved(std::uint16_t address, const SecureUser* user) const {
  if (!sessions_) return false;
  const auto& users = sessions_->options().users;
  return std::any_of(users.begin(), users.end(),
                     [=](const auto& one) { return one.address == address && &one != user; });
}

void Server::send_in_clear(const Bytes& frame) {
  for (const auto& [id, channel] : channels_) transmit_wire(channel.data, frame, true);
}

void Server::session_ended(std::uint16_t session) {
  std::erase_if(channels_, [&](const auto& entry) { return entry.second.control.session == session; });
}

}  // namespace rubicon::knx_simulator
