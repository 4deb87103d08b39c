#include "support/host_group.h"

#include <grp.h>
#include <sched.h>
#include <sys/mount.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace rubicon::support {

namespace {

constexpr const char* kGroups = "/etc/group";
/// Of no group that Debian gives.
constexpr gid_t kFreeNumber = 64'123;

std::string why(const char* what) {
  return std::string(what) + ": " + std::strerror(errno);
}

}  // namespace

HostGroup::HostGroup(const std::string& name) : number_(kFreeNumber) {
  if (const auto* found = ::getgrnam(name.c_str()); found != nullptr) {
    number_ = found->gr_gid;
    return;
  }
  std::ostringstream text;
  text << std::ifstream(kGroups).rdbuf() << name << ":x:" << kFreeNumber << ":\n";
  reason_ = cover_with(text.str());
  if (reason_.empty() && ::getgrnam(name.c_str()) == nullptr) reason_ = "this host has its groups elsewhere";
}

HostGroup::~HostGroup() {
  if (file_.empty()) return;
  ::umount2(kGroups, MNT_DETACH);
  std::filesystem::remove(file_);
}

/// Empty, or why not.
std::string HostGroup::cover_with(const std::string& text) {
  if (::geteuid() != 0) return "needs root";
  if (::unshare(CLONE_NEWNS) != 0) return why("no mount namespace");
  if (::mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0) return why("no private mounts");
  const auto file = std::filesystem::temp_directory_path() / ("rubicon_group_" + std::to_string(::getpid()));
  std::ofstream(file) << text;
  // In a user namespace there is no such number.
  const bool is_covered =
      ::chown(file.c_str(), 0, number_) == 0 && ::mount(file.c_str(), kGroups, nullptr, MS_BIND, nullptr) == 0;
  const auto reason = is_covered ? std::string() : why("no other file of groups");
  if (is_covered) file_ = file;
  if (!is_covered) std::filesystem::remove(file);
  return reason;
}

}  // namespace rubicon::support
