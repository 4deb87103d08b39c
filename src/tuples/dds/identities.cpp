#include "tuples/dds/identities.h"

#include <fmt/format.h>

#include <algorithm>

namespace rubicon::tuples::dds {

void Identities::add_own(const GuidPrefix& participant) {
  auto member = std::make_shared<const Member>(trust_->own());
  const std::lock_guard lock(mutex_);
  own_[participant] = std::move(member);
}

void Identities::clear_own() {
  const std::lock_guard lock(mutex_);
  own_.clear();
}

bool Identities::is_own(const GuidPrefix& participant) const {
  const std::lock_guard lock(mutex_);
  return own_.contains(participant);
}

std::shared_ptr<const Member> Identities::who(const GuidPrefix& participant) const {
  {
    const std::lock_guard lock(mutex_);
    if (const auto own = own_.find(participant); own != own_.end()) return own->second;
  }
  auto member = trust_->who(participant);
  return member ? std::make_shared<const Member>(std::move(*member)) : nullptr;
}

bool Claims::may_use(const GuidPrefix& participant, OwnerId id) {
  if (!identities_) return true;
  const auto member = identities_->who(participant);
  if (member && member->may_use(id)) return true;
  {
    const std::lock_guard lock(mutex_);
    ++refused_;
    if (noted_.size() >= kMaxNoted) return false;
    noted_.push_back({participant, member ? member->name : std::string(), id});
  }
  wake_();
  return false;
}

std::vector<FalseClaim> Claims::take() {
  const std::lock_guard lock(mutex_);
  return std::exchange(noted_, {});
}

std::uint64_t Claims::refused() const {
  const std::lock_guard lock(mutex_);
  return refused_;
}

GuidPrefix prefix_of(const Participant& participant) {
  GuidPrefix prefix{};
  std::copy_n(participant.begin(), prefix.size(), prefix.begin());
  return prefix;
}

Participant participant_of(const GuidPrefix& prefix) {
  constexpr std::array<std::uint8_t, 4> kParticipant{0, 0, 1, 0xc1};  // DDSI-RTPS 2.5, 9.3.1.3
  Participant guid{};
  std::copy(kParticipant.begin(), kParticipant.end(), std::copy(prefix.begin(), prefix.end(), guid.begin()));
  return guid;
}

std::string text_of(const Member& member) {
  return fmt::format("{} (certificate {})", member.name, member.serial);
}

}  // namespace rubicon::tuples::dds
