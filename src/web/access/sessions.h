#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "rubicon/time.hpp"
#include "web/access/sha256.h"
#include "web/caller.h"

namespace rubicon::web::access {

/// Who logged in with a browser. Only the digest of the secret in a cookie is kept. An id is never taken from a client:
/// each login makes a new one.
class Sessions {
 public:
  static constexpr std::size_t kMost = 256;
  static constexpr Duration kIdle = std::chrono::hours(12);      ///< since the last request
  static constexpr Duration kLongest = std::chrono::hours(168);  ///< since the login

  /// The secret for the cookie. Beyond kMost sessions the one that was idle longest ends.
  std::string open(const std::string& name, SteadyTime now);
  /// The name of the token that opened it; renews it.
  std::optional<std::string> find(std::string_view secret, SteadyTime now);
  void close(std::string_view secret);
  std::size_t size() const { return sessions_.size(); }

 private:
  struct Session {
    std::string name;
    SteadyTime opened, used;
  };

  std::map<Digest, Session> sessions_;
};

}  // namespace rubicon::web::access
