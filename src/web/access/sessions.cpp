#include "web/access/sessions.h"

#include <algorithm>

namespace rubicon::web::access {

std::string Sessions::open(const Digest& token, SteadyTime now) {
  if (sessions_.size() >= kMost) {
    sessions_.erase(std::min_element(sessions_.begin(), sessions_.end(),
                                     [](const auto& a, const auto& b) { return a.second.used < b.second.used; }));
  }
  auto secret = random_secret();
  sessions_[sha256(secret)] = {++last_id_, token, now, now};
  return secret;
}

const Sessions::Session* Sessions::find(std::string_view secret, SteadyTime now) {
  // Looked up by the digest: how long that takes says nothing about the secret.
  return renew(sessions_.find(sha256(secret)), now);
}

bool Sessions::renew(std::uint64_t id, SteadyTime now) {
  return renew(std::find_if(sessions_.begin(), sessions_.end(),
                            [id](const auto& entry) { return entry.second.id == id; }),
               now) != nullptr;
}

const Sessions::Session* Sessions::renew(Place place, SteadyTime now) {
  if (place == sessions_.end()) return nullptr;
  auto& session = place->second;
  if (now - session.used >= kIdle || now - session.opened >= kLongest) {
    sessions_.erase(place);
    return nullptr;
  }
  session.used = now;
  return &session;
}

void Sessions::close(std::string_view secret) {
  sessions_.erase(sha256(secret));
}

void Sessions::keep_only(const std::vector<Digest>& known) {
  std::erase_if(sessions_, [&known](const auto& entry) {
    return std::find(known.begin(), known.end(), entry.second.token) == known.end();
  });
}

}  // namespace rubicon::web::access
