#include "transport/host_name.h"

#include <fmt/format.h>
#include <pwd.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <fstream>

namespace rubicon::transport {

std::string host_name() {
  char name[256] = {};
  return ::gethostname(name, sizeof name - 1) == 0 ? std::string(name) : std::string();
}

std::string own_process() {
  std::array<char, 1024> text{};
  passwd entry{};
  passwd* found = nullptr;
  const auto user = ::geteuid();
  const bool named = ::getpwuid_r(user, &entry, text.data(), text.size(), &found) == 0 && found != nullptr;
  return "pid " + std::to_string(::getpid()) + " of " + (named ? found->pw_name : "uid " + std::to_string(user));
}

std::string host_id(const std::string& purpose) {
  std::string boot;
  std::getline(std::ifstream("/proc/sys/kernel/random/boot_id"), boot);
  std::array<char, 64> space{};
  const auto length = ::readlink("/proc/self/ns/net", space.data(), space.size());
  const auto text =
      purpose + '\n' + boot + '\n' + std::string(space.data(), length > 0 ? static_cast<std::size_t>(length) : 0);
  std::uint64_t hash = 0xcbf29ce484222325;  // FNV-1a
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  return fmt::format("{:016x}", hash);
}

}  // namespace rubicon::transport
