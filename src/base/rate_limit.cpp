#include "base/rate_limit.h"

namespace rubicon::base {

namespace {
constexpr std::size_t kMaxSubjects = 1024;
}

bool RateLimit::allow(const std::string& subject, SteadyTime now) {
  const bool known = last_.contains(subject);
  if (!known && last_.size() >= kMaxSubjects && now - cleaned_ >= period_) {
    std::erase_if(last_, [&](const auto& one) { return now - one.second >= period_; });
    cleaned_ = now;
  }
  const auto& name = known || last_.size() < kMaxSubjects ? subject : std::string();
  const auto [it, fresh] = last_.try_emplace(name, now);
  if (!fresh && now - it->second < period_) {
    ++swallowed_;
    return false;
  }
  it->second = now;
  return true;
}

}  // namespace rubicon::base
