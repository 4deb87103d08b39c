#include "web/access/attempts.h"

#include <arpa/inet.h>

#include <iterator>

namespace rubicon::web::access {

namespace {

constexpr std::size_t kNetworkBytes = 8;

/// An IPv4 address as it is; the network of an IPv6 address.
std::string host_of(const std::string& address) {
  in6_addr parsed{};
  if (::inet_pton(AF_INET6, address.c_str(), &parsed) != 1) return address;
  return {reinterpret_cast<const char*>(parsed.s6_addr), kNetworkBytes};
}

}  // namespace

bool Attempts::may_try(const std::string& address, SteadyTime now) {
  forget(now);
  const auto found = failures_.find(subject(address));
  return found == failures_.end() || found->second.size() < kMost;
}

void Attempts::failed(const std::string& address, SteadyTime now) {
  forget(now);
  auto& times = failures_[subject(address)];
  times.push_back(now);
  if (times.size() > kMost) times.pop_front();
}

std::string Attempts::subject(const std::string& address) const {
  auto host = host_of(address);
  const bool full = failures_.size() >= kMostAddresses && !failures_.contains(host);
  return full ? std::string() : host;
}

void Attempts::forget(SteadyTime now) {
  for (auto entry = failures_.begin(); entry != failures_.end();) {
    auto& times = entry->second;
    while (!times.empty() && now - times.front() >= kPeriod) times.pop_front();
    entry = times.empty() ? failures_.erase(entry) : std::next(entry);
  }
}

}  // namespace rubicon::web::access
