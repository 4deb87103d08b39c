#pragma once

#include <sys/types.h>

#include <string>

namespace rubicon::support {

/// While it lives, this process and those that it starts see a group of this name, in a mount namespace of their own.
/// If the host has it, that one. Needs root; without that exists() is false and nothing is changed.
class HostGroup {
 public:
  explicit HostGroup(const std::string& name);
  ~HostGroup();
  HostGroup(const HostGroup&) = delete;
  HostGroup& operator=(const HostGroup&) = delete;

  bool exists() const { return reason_.empty(); }
  /// Why not.
  const std::string& reason() const { return reason_; }
  gid_t number() const { return number_; }

 private:
  std::string cover_with(const std::string& text);

  gid_t number_ = 0;
  std::string file_;  ///< what covers that of the host
  std::string reason_;
};

}  // namespace rubicon::support
