#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "rubicon/address.hpp"
#include "rubicon/result.hpp"

namespace rubicon::web {

/// What a caller may do; each role includes those before it.
enum class Role : std::uint8_t {
  kNone,     ///< not known: nothing but the page itself and its login
  kView,     ///< read and subscribe, passively or with demand
  kCommand,  ///< set tuples, send messages
  kAdmin,    ///< inbox, reload, recorders, messages that change an installation
};

/// Who sent a request, as far as the server knows.
struct Caller {
  std::string name;  ///< of the token; `local` without tokens
  Role role = Role::kNone;
  std::string peer;                  ///< IP address
  std::uint64_t session = 0;         ///< of the login that the request's cookie names; 0 = none
  std::vector<std::string> roles{};  ///< of the token besides its role: names that rules may have
};

enum class Verb : std::uint8_t { kRead, kWake, kSet, kSend };

/// What the role of a caller permits; where the ecology has rights, api::Permission asks them too. `key` is a tuple key
/// (kSet), a pattern (kRead, kWake) or a content type (kSend). Keys that steer the island itself (inbox, settings,
/// recorders, lines) and messages that change an installation (model::is_admin_type()) need kAdmin.
bool may(const Caller& caller, Verb verb, OwnerId owner, std::string_view key);

/// Names and values, decoded, in their order.
using Fields = std::vector<std::pair<std::string, std::string>>;

/// One HTTP request with its whole body (RFC 9110). The server checked length, Host and Origin before.
struct Request {
  std::string method;  ///< `GET`
  std::string path;    ///< as it was sent, without query: each part is still percent-encoded
  Fields query;        ///< percent-decoded
  Fields headers;      ///< names in lower case
  std::string body;
  Caller caller;

  /// Empty if there is none.
  std::string_view header(std::string_view name) const;
  std::optional<std::string_view> parameter(std::string_view name) const;
};

/// One WebSocket, or one stream of server-sent events, for the program that writes it: text frames in both directions.
/// The sender of frames is asked for each one when the line is free, so that a slow reader costs what changed, not
/// what was sent.
class Conversation {
 public:
  virtual ~Conversation() = default;
  /// One text frame of the client, valid UTF-8, at most 64 KiB. Never called for an event stream.
  virtual void received(std::string_view text) = 0;
  /// The next frame; nullopt: nothing at present, `wake` will be called. It is called when the frame before it was
  /// written.
  virtual std::optional<std::string> next() = 0;
  /// Whether the client said who it is. Until then its connection may be closed to make room for others.
  virtual bool has_caller() const { return true; }
};

struct ConversationCallbacks {
  std::function<void()> wake;                          ///< there may be a next frame; may be called at any time
  std::function<void(std::string_view reason)> close;  ///< ends the conversation, in a later turn
};

struct Response {
  unsigned status = 200;
  std::string content_type{};  ///< empty = no body
  std::string body{};
  Fields headers{};
  /// Instead of a body: frames follow, each one event of a stream, until the client or the conversation ends.
  std::function<std::unique_ptr<Conversation>(ConversationCallbacks)> stream{};
};

/// Whether the site answers a path; the page has all others.
bool is_site_path(std::string_view path);

using Respond = std::function<void(Response)>;

/// A request that is being answered; destroying it cancels that, without a call.
class Exchange {
 public:
  virtual ~Exchange() = default;
};

/// What the server serves: the application behind HTTP and WebSocket. It knows no sockets.
class Site {
 public:
  virtual ~Site() = default;
  /// Calls `respond` once, now or in a later turn. The result may be null if it has responded.
  virtual std::unique_ptr<Exchange> handle(const Request& request, Respond respond) = 0;
  /// Whether the body of a request may be a whole file; its caller is known.
  virtual bool takes_file(const Request&) const { return false; }
  /// A WebSocket was opened at the path of the API. The caller has the role kNone if its first frame has to name a
  /// token.
  virtual std::unique_ptr<Conversation> open(const Caller& caller, ConversationCallbacks calls) = 0;
};

/// `{"error":{"code":"refused","text":...}}`.
Response error_response(unsigned status, ErrorCode code, std::string_view text);
/// The same for an error of the tree, with its status: invalid 400, not-found 404, refused 403, busy 429, unreachable
/// 503, expired 504.
Response error_response(const Error& error);
/// The answer to a token that was not accepted: 401 (RFC 6750, section 3), or 429 after too many.
Response refusal_of(const Error& error);

}  // namespace rubicon::web
