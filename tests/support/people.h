#pragma once

#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <string>
#include <vector>

namespace rubicon::support {

/// Makes the folder one of several users, as the packages do: islands run as `service`, people have the group. false:
/// in a user namespace this process is root and may give nothing to others.
inline bool share_folder(const std::string& folder, unsigned service, unsigned group) {
  const auto make = [&](const std::string& name, unsigned owner, mode_t mode) {
    const auto path = (std::filesystem::path(folder) / name).string();
    std::filesystem::create_directories(path);
    return ::chown(path.c_str(), owner, group) == 0 && ::chmod(path.c_str(), mode) == 0;
  };
  return ::geteuid() == 0 && make("", 0, 0750) && make("islands", service, 02750) && make("people", 0, 03770);
}

/// The command as that user with its own group and, unless that is 0, another one. It needs no account.
inline std::vector<std::string> as_user(unsigned user, unsigned group, std::vector<std::string> words) {
  const auto number = std::to_string(user);
  std::vector<std::string> all{"setpriv", "--reuid=" + number, "--regid=" + number,
                               group != 0 ? "--groups=" + std::to_string(group) : "--clear-groups"};
  all.insert(all.end(), words.begin(), words.end());
  return all;
}

}  // namespace rubicon::support
