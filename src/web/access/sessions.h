#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "rubicon/time.hpp"
#include "web/access/sha256.h"

namespace rubicon::web::access {

/// Who logged in with a browser. Only the digest of the secret in a cookie is kept. An id is never taken from a client:
/// each login makes a new one.
class Sessions {
 public:
  static constexpr std::size_t kMost = 256;
  static constexpr Duration kIdle = std::chrono::hours(12);      ///< since the last request
  static constexpr Duration kLongest = std::chrono::hours(168);  ///< since the login

  struct Session {
    std::uint64_t id = 0;  ///< above 0; never used again
    Digest token{};        ///< the hash of the token that opened it: another token of the same name does not renew it
    SteadyTime opened, used;
  };

  /// The secret for the cookie. Beyond kMost sessions the one that was idle longest ends.
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

}  // namespace rubicon::web::access
