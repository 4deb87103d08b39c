#include "transport/host_name.h"

#include <pwd.h>
#include <unistd.h>

#include <array>

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

}  // namespace rubicon::transport
