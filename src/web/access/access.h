#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/scheduler.h"
#include "rubicon/result.hpp"
#include "rubicon/time.hpp"
#include "web/access/token_file.h"
#include "web/exchange.h"

namespace rubicon::web::access {

/// Counts wrong tokens: after 5 in a minute an address waits. IPv6 addresses count by their network of 64 bits, which
/// is what one host gets. Bounded: beyond 1024 addresses all new ones share one count.
class Attempts {
 public:
  static constexpr std::size_t kMaxCount = 5;
  static constexpr std::size_t kMaxAddressCount = 1024;
  static constexpr Duration kPeriod = std::chrono::minutes(1);

  bool may_try(const std::string& address, SteadyTime now);
  void failed(const std::string& address, SteadyTime now);
  std::size_t addresses() const { return failures_.size(); }

 private:
  std::string subject(const std::string& address) const;
  void forget(SteadyTime now);

  std::map<std::string, std::deque<SteadyTime>> failures_;
};

/// Which names the server answers to, and whose pages may use it. A page of another site that a browser shows can make
/// the browser send requests here, and a name of that site can be made to lead to our address (DNS rebinding).
struct OriginRules {
  std::vector<std::string> hosts;    ///< names besides IP addresses and `localhost`
  std::vector<std::string> origins;  ///< `https://hall.lan`: other pages, and the page behind a proxy

  /// Whether Host names an IP address, `localhost`, or one of `hosts`; the port does not count.
  bool is_own_host(std::string_view host) const;
  /// Whether a page of this origin (RFC 6454) is ours: it has our Host and scheme, or is one of `origins`.
  bool is_own_origin(std::string_view origin, std::string_view host, bool secure) const;
  /// Whether `origins` lists it.
  bool is_listed(std::string_view origin) const;
};

/// Who logged in with a browser. Only the digest of the secret in a cookie is kept. An id is never taken from a client:
/// each login makes a new one.
class Sessions {
 public:
  static constexpr std::size_t kMaxCount = 256;
  static constexpr Duration kIdle = std::chrono::hours(12);      ///< since the last request
  static constexpr Duration kMaxTime = std::chrono::hours(168);  ///< since the login

  struct Session {
    std::uint64_t id = 0;  ///< above 0; never used again
    Digest token{};        ///< the hash of the token that opened it: another token of the same name does not renew it
    SteadyTime opened, used;
  };

  /// The secret for the cookie. Beyond kMaxCount sessions the one that was idle longest ends.
  std::string open(const Digest& token, SteadyTime now);
  /// The session of a cookie; renews it. nullptr: there is none, or it has ended.
  const Session* find(std::string_view secret, SteadyTime now);
  /// Renews the session with this id. False: it has ended.
  bool renew(std::uint64_t id, SteadyTime now);
  void close(std::string_view secret);
  /// Ends the sessions whose token is not among `known`.
  void keep_only(const std::vector<Digest>& known);
  std::size_t size() const { return sessions_.size(); }

 private:
  using Place = std::map<Digest, Session>::iterator;
  const Session* renew(Place place, SteadyTime now);

  std::map<Digest, Session> sessions_;
  std::uint64_t last_id_ = 0;
};

struct AccessRules {
  bool needs_token = false;
  OriginRules origins;
  std::string cookie = "rubicon";  ///< name of the cookie
};

/// Decides who sent a request. The scheduler must outlive it.
class Access {
 public:
  Access(Scheduler& scheduler, AccessRules rules) : scheduler_(scheduler), rules_(std::move(rules)) {}

  const AccessRules& rules() const { return rules_; }
  /// The tokens from now on. Sessions that other tokens opened end. True: a token that was there is not there any
  /// longer, or has another role, so that what was opened with it has to end.
  bool take(std::vector<Token> tokens);

  /// Browsers send the cookies of a host to all its ports: each has a name of its own.
  void name_cookie(std::uint16_t port, bool secure);

  /// Whose token it is. kRefused: it is not one of ours; kBusy: nor is it, and too many wrong ones came from this
  /// address. A right one is accepted also then: behind a proxy all clients have one address.
  Result<Caller> by_token(std::string_view token, const std::string& peer);
  /// Judges Host, Origin, cookie and bearer of a request, and names its caller. A response refuses the request.
  std::optional<Response> admit(Request& request, bool secure);
  /// POST (JSON {token}) and DELETE of the session.
  Response session(const Request& request, bool secure);
  /// A conversation of this session goes on, which counts as use of it. False: the session has ended.
  bool renew_session(std::uint64_t id);
  /// The fields that let pages of listed origins read a response (Fetch standard, CORS).
  Fields origin_fields(const Request& request) const;

 private:
  std::optional<Response> check_origin(const Request& request, bool secure) const;
  std::optional<Response> name_caller(Request& request);
  Response log_in(const Request& request, bool secure);
  std::string cookie_of(const Request& request) const;
  std::string cookie_text(std::string_view secret, bool secure) const;
  const Token* find(const Digest& hash) const;

  Scheduler& scheduler_;
  AccessRules rules_;
  std::vector<Token> tokens_;
  Attempts attempts_;
  Sessions sessions_;
};

}  // namespace rubicon::web::access
