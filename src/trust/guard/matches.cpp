#include "trust/guard/matches.h"

#include <fnmatch.h>

#include <algorithm>

namespace rubicon::trust::guard {

namespace {

struct OfThread {
  std::string topic;
  std::vector<std::string> partitions;
  std::optional<Approval> approval;
  const void* endpoint = nullptr;  ///< that the last taken approval was for
};

OfThread& of_thread() {
  thread_local OfThread mine;
  return mine;
}

bool is_pattern(const std::string& name) {
  return name.find_first_of("*?[") != std::string::npos;
}

bool name_matches(const std::string& one, const std::string& other) {
  if (is_pattern(one) && is_pattern(other)) return false;
  if (is_pattern(one)) return ::fnmatch(one.c_str(), other.c_str(), 0) == 0;
  if (is_pattern(other)) return ::fnmatch(other.c_str(), one.c_str(), 0) == 0;
  return one == other;
}

/// Cyclone's own rule: equal, or one of them does not claim to be valid.
bool compatible(std::uint32_t one, std::uint32_t other) {
  constexpr std::uint32_t kValid = 1U << 31U;
  return one == other || (one & kValid) == 0 || (other & kValid) == 0;
}

}  // namespace

bool partitions_match(const std::vector<std::string>& some, const std::vector<std::string>& others) {
  static const std::vector<std::string> kDefault{""};
  const auto& left = some.empty() ? kDefault : some;
  const auto& right = others.empty() ? kDefault : others;
  return std::ranges::any_of(left, [&](const auto& one) {
    return std::ranges::any_of(right, [&](const auto& other) { return name_matches(one, other); });
  });
}

void Matches::prepare(std::string topic, std::vector<std::string> partitions) {
  of_thread().topic = std::move(topic);
  of_thread().partitions = std::move(partitions);
}

void Matches::local_endpoint(Handle local, bool builtin, Masks masks) {
  auto& mine = of_thread();
  const std::lock_guard lock(mutex_);
  locals_[local] = {builtin, masks, std::exchange(mine.topic, {}), std::exchange(mine.partitions, {})};
}

void Matches::participant(Handle permissions, Handle remote, Handle identity) {
  const std::lock_guard lock(mutex_);
  participants_[permissions] = remote;
  identities_[remote] = identity;
}

void Matches::participant_gone(Handle remote) {
  const std::lock_guard lock(mutex_);
  std::erase_if(participants_, [remote](const auto& entry) { return entry.second == remote; });
  identities_.erase(remote);
}

void Matches::permissions_gone(Handle permissions) {
  const std::lock_guard lock(mutex_);
  participants_.erase(permissions);
}

void Matches::ask() {
  of_thread().approval.reset();
}

void Matches::approve(Approval approval) {
  of_thread().approval = std::move(approval);
}

std::optional<std::string> Matches::refusal(Kind kind, Handle local, Handle remote) {
  auto& mine = of_thread();
  const auto approval = std::exchange(mine.approval, std::nullopt);
  mine.endpoint = nullptr;
  const std::lock_guard lock(mutex_);
  const auto own = locals_.find(local);
  if (own == locals_.end()) return "an endpoint of this process is not known";
  if (own->second.builtin) return std::nullopt;
  const std::string what = kind == Kind::Writer ? "a writer of " : "a reader of ";
  const auto unasked =
      what + own->second.topic + " was announced without the attributes that permissions are asked for";
  if (!approval || approval->kind != kind) return unasked;
  const auto asked = participants_.find(approval->permissions);
  if (asked == participants_.end() || asked->second != remote) return unasked;
  if (approval->topic != own->second.topic || !partitions_match(approval->partitions, own->second.partitions) ||
      !compatible(approval->masks.attributes, own->second.masks.attributes) ||
      !compatible(approval->masks.plugin, own->second.masks.plugin))
    return unasked;
  if (matched_.contains({local, approval->endpoint})) return unasked;
  mine.endpoint = approval->endpoint;
  return std::nullopt;
}

void Matches::matched(Handle match, Handle local) {
  const auto* endpoint = std::exchange(of_thread().endpoint, nullptr);
  if (endpoint == nullptr) return;
  const std::lock_guard lock(mutex_);
  matches_[match] = {local, endpoint};
  matched_.insert({local, endpoint});
}

void Matches::endpoint_gone(Handle handle) {
  const std::lock_guard lock(mutex_);
  if (locals_.erase(handle) > 0) {
    matched_.erase(matched_.lower_bound({handle, nullptr}), matched_.lower_bound({handle + 1, nullptr}));
  }
  const auto match = matches_.find(handle);
  if (match == matches_.end()) return;
  matched_.erase(match->second);
  matches_.erase(match);
}

Handle Matches::identity_of(Handle remote) const {
  const std::lock_guard lock(mutex_);
  const auto found = identities_.find(remote);
  return found == identities_.end() ? 0 : found->second;
}

Matches& matches() {
  static Matches all;
  return all;
}

}  // namespace rubicon::trust::guard
