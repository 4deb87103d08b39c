#include "gateway/seen_messages.h"

#include <algorithm>
#include <random>

namespace rubicon::gateway {

namespace {

__extension__ using Wide = unsigned __int128;
constexpr std::uint64_t kPrime = (std::uint64_t{1} << 61) - 1;

/// A number below kPrime.
std::uint64_t make_secret() {
  std::random_device source;
  return ((std::uint64_t{source()} << 32) | source()) % kPrime;
}

}  // namespace

SeenMessages::SeenMessages() : secret_(make_secret()) {}

/// A polynomial of the bytes at a secret point: two texts of n bytes have the same value at no more than n points.
std::uint64_t SeenMessages::place_of(const Address& to) const {
  std::uint64_t value = 1;
  const auto add = [&](std::uint64_t next) {
    value = static_cast<std::uint64_t>((Wide{value} * secret_ + next) % kPrime);
  };
  add(number(to.island));
  for (const auto* name : {&to.network, &to.device}) {
    for (const char byte : *name) add(static_cast<unsigned char>(byte) + 1U);
    add(0);  // the end of a name
  }
  return value;
}

bool SeenMessages::seen(const Address& to, IslandId origin, std::uint64_t number) const {
  const auto found = windows_.find(origin);
  if (found == windows_.end() || number > found->second.highest) return false;
  const auto& numbers = found->second.numbers;
  return std::find(numbers.begin(), numbers.end(), Seen{number, place_of(to)}) != numbers.end();
}

void SeenMessages::note(const Address& to, IslandId origin, std::uint64_t number) {
  Window& known = window(origin);
  known.highest = std::max(known.highest, number);
  if (known.numbers.size() < kNumbers) {
    known.numbers.push_back({number, place_of(to)});
    return;
  }
  known.numbers[known.next] = {number, place_of(to)};
  known.next = (known.next + 1) % kNumbers;
}

SeenMessages::Window& SeenMessages::window(IslandId origin) {
  if (const auto found = windows_.find(origin); found != windows_.end()) {
    by_age_.splice(by_age_.begin(), by_age_, found->second.age);
    return found->second;
  }
  if (windows_.size() >= kOrigins) {
    windows_.erase(by_age_.back());
    by_age_.pop_back();
  }
  by_age_.push_front(origin);
  Window& fresh = windows_[origin];
  fresh.age = by_age_.begin();
  return fresh;
}

}  // namespace rubicon::gateway
