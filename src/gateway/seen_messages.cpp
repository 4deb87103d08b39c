#include "gateway/seen_messages.h"

namespace rubicon::gateway {

namespace {
constexpr std::size_t kMessages = 4096;
constexpr std::size_t kOrigins = 1024;
}  // namespace

bool SeenMessages::first(IslandId origin, std::uint64_t number) {
  const auto [found, fresh] = windows_.try_emplace(origin);
  if (fresh) {
    origins_.push_back(origin);
    if (origins_.size() > kOrigins) {
      windows_.erase(origins_.front());
      origins_.pop_front();
    }
  }
  auto& window = windows_[origin];
  if (!window.numbers.insert(number).second) return false;
  window.order.push_back(number);
  if (window.order.size() > kMessages) {
    window.numbers.erase(window.order.front());
    window.order.pop_front();
  }
  return true;
}

}  // namespace rubicon::gateway
