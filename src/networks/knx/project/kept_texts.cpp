#include "networks/knx/project/kept_texts.h"

#include <fmt/format.h>

namespace rubicon::networks::knx::project {

namespace {

/// Of an element of the set besides its bytes: the element, its bucket and the overhead of the heap.
constexpr std::size_t kOverhead = 96;

}  // namespace

std::string_view KeptTexts::keep(std::string_view text) {
  if (text.empty()) return {};
  if (const auto found = texts_.find(text); found != texts_.end()) return *found;
  if (!charge(text.size() + kOverhead)) return {};
  return *texts_.emplace(text).first;
}

bool KeptTexts::charge(std::size_t bytes) {
  if (exceeded_ || bytes > most_ - used_) {
    exceeded_ = true;
    return false;
  }
  used_ += bytes;
  return true;
}

std::string KeptTexts::why() const {
  return fmt::format("more than {} bytes of names and texts: file refused, nothing imported", most_);
}

}  // namespace rubicon::networks::knx::project
