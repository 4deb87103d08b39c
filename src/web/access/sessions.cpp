#include "web/access/sessions.h"

#include <algorithm>

namespace rubicon::web::access {

std::string Sessions::open(const std::string& name, SteadyTime now) {
  if (sessions_.size() >= kMost) {
    sessions_.erase(std::min_element(sessions_.begin(), sessions_.end(),
                                     [](const auto& a, const auto& b) { return a.second.used < b.second.used; }));
  }
  auto secret = random_secret();
  sessions_[sha256(secret)] = {name, now, now};
  return secret;
}

std::optional<std::string> Sessions::find(std::string_view secret, SteadyTime now) {
  // Looked up by the digest: how long that takes says nothing about the secret.
  const auto found = sessions_.find(sha256(secret));
  if (found == sessions_.end()) return std::nullopt;
  auto& session = found->second;
  if (now - session.used >= kIdle || now - session.opened >= kLongest) {
    sessions_.erase(found);
    return std::nullopt;
  }
  session.used = now;
  return session.name;
}

void Sessions::close(std::string_view secret) {
  sessions_.erase(sha256(secret));
}

}  // namespace rubicon::web::access
