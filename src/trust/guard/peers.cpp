#include "trust/guard/peers.h"

#include <openssl/sha.h>

#include <algorithm>

namespace rubicon::trust::guard {

namespace {

Digest digest_of(std::string_view text) {
  Digest digest{};
  if (!text.empty()) ::SHA256(reinterpret_cast<const unsigned char*>(text.data()), text.size(), digest.data());
  return digest;
}

}  // namespace

bool Peers::met(Handle identity, const GuidPrefix& prefix) {
  const std::lock_guard lock(mutex_);
  if (const auto known = identities_.find(identity); known != identities_.end()) {
    if (known->second.prefix == prefix) return true;
    erase(identity);
  }
  if (identities_.size() >= kMost && !make_room()) return false;
  auto& stranger = identities_[identity];
  stranger.prefix = prefix;
  stranger.order = next_++;
  strangers_[stranger.order] = identity;
  return true;
}

bool Peers::make_room() {
  for (const auto* group : {&strangers_, &beginners_}) {
    if (group->empty()) continue;
    erase(group->begin()->second);
    return true;
  }
  return false;
}

void Peers::shakes_hands(Handle handshake, Handle identity) {
  const std::lock_guard lock(mutex_);
  const auto known = identities_.find(identity);
  if (known == identities_.end()) return;
  if (strangers_.erase(known->second.order) > 0) beginners_[known->second.order] = identity;
  if (const auto former = handshakes_.find(handshake); former != handshakes_.end()) {
    if (former->second == identity) return;
    std::erase(identities_[former->second].handshakes, handshake);
  }
  auto& all = known->second.handshakes;
  if (all.size() >= kMostHandshakes) {
    handshakes_.erase(all.front());
    all.erase(all.begin());
  }
  all.push_back(handshake);
  handshakes_[handshake] = identity;
}

void Peers::is_over(Handle handshake) {
  const std::lock_guard lock(mutex_);
  const auto known = handshakes_.find(handshake);
  if (known == handshakes_.end()) return;
  std::erase(identities_.at(known->second).handshakes, handshake);
  handshakes_.erase(known);
}

std::optional<Peers::Known> Peers::of_handshake(Handle handshake) const {
  const std::lock_guard lock(mutex_);
  const auto found = handshakes_.find(handshake);
  if (found == handshakes_.end()) return std::nullopt;
  const auto identity = identities_.find(found->second);
  if (identity == identities_.end()) return std::nullopt;
  return Known{identity->first, identity->second.prefix};
}

void Peers::authenticated(Handle identity, Certificate certificate) {
  const std::lock_guard lock(mutex_);
  const auto known = identities_.find(identity);
  if (known == identities_.end()) return;
  strangers_.erase(known->second.order);
  beginners_.erase(known->second.order);
  known->second.certificate = std::move(certificate);
  known->second.wait = {};
  authenticated_[known->second.prefix] = identity;
}

void Peers::failed(Handle identity, Clock::time_point now, std::string_view foreign) {
  const auto digest = digest_of(foreign);
  const std::lock_guard lock(mutex_);
  const auto known = identities_.find(identity);
  if (known == identities_.end()) return;
  auto& wait = known->second.wait;
  wait = std::clamp(2 * wait, kShortestWait, kLongestWait);
  known->second.not_before = now + wait;
  known->second.foreign = digest;
}

bool Peers::must_wait(Handle identity, Clock::time_point now) const {
  const std::lock_guard lock(mutex_);
  const auto known = identities_.find(identity);
  return known != identities_.end() && known->second.wait.count() > 0 && now < known->second.not_before;
}

bool Peers::must_wait(Handle identity, std::string_view certificate, Clock::time_point now) const {
  if (certificate.empty() || !must_wait(identity, now)) return false;
  const auto digest = digest_of(certificate);
  const std::lock_guard lock(mutex_);
  const auto known = identities_.find(identity);
  return known != identities_.end() && known->second.foreign == digest;
}

void Peers::gone(Handle identity) {
  const std::lock_guard lock(mutex_);
  erase(identity);
}

void Peers::erase(Handle identity) {
  const auto known = identities_.find(identity);
  if (known == identities_.end()) return;
  strangers_.erase(known->second.order);
  beginners_.erase(known->second.order);
  for (const auto handshake : known->second.handshakes) handshakes_.erase(handshake);
  const auto named = authenticated_.find(known->second.prefix);
  if (named != authenticated_.end() && named->second == identity) authenticated_.erase(named);
  identities_.erase(known);
}

std::optional<Certificate> Peers::who(const GuidPrefix& prefix) const {
  const std::lock_guard lock(mutex_);
  const auto found = authenticated_.find(prefix);
  if (found == authenticated_.end()) return std::nullopt;
  auto certificate = identities_.at(found->second).certificate;
  if (certificate && revoked_.contains(certificate->serial)) return std::nullopt;
  return certificate;
}

std::optional<Certificate> Peers::who(Handle identity) const {
  const std::lock_guard lock(mutex_);
  const auto known = identities_.find(identity);
  return known == identities_.end() ? std::nullopt : known->second.certificate;
}

std::optional<GuidPrefix> Peers::prefix_of(Handle identity) const {
  const std::lock_guard lock(mutex_);
  const auto known = identities_.find(identity);
  if (known == identities_.end()) return std::nullopt;
  return known->second.prefix;
}

void Peers::revoke(std::set<std::string> serials) {
  const std::lock_guard lock(mutex_);
  revoked_ = std::move(serials);
}

bool Peers::meets_revoked() const {
  const std::lock_guard lock(mutex_);
  return std::any_of(authenticated_.begin(), authenticated_.end(), [this](const auto& one) {
    const auto& certificate = identities_.at(one.second).certificate;
    return certificate && revoked_.contains(certificate->serial);
  });
}

bool Peers::is_revoked(const std::string& serial) const {
  const std::lock_guard lock(mutex_);
  return revoked_.contains(serial);
}

std::size_t Peers::size() const {
  const std::lock_guard lock(mutex_);
  return identities_.size();
}

Peers& peers() {
  static Peers all;
  return all;
}

}  // namespace rubicon::trust::guard
