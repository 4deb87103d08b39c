#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/scheduler.h"
#include "rubicon/result.hpp"
#include "web/access/attempts.h"
#include "web/access/origin_rules.h"
#include "web/access/sessions.h"
#include "web/access/token_file.h"
#include "web/exchange.h"

namespace rubicon::web::access {

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
