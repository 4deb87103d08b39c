#pragma once

#include <optional>
#include <string>

namespace rubicon::support {

/// While it lives, this process and those that it starts meet other programs of the host in a folder of their own
/// (RUBICON_FOLDER), which is removed at its end. It stands for a host, or for a test program on one.
class MeetingFolder {
 public:
  MeetingFolder();
  /// Enters that folder for a while, and removes nothing.
  explicit MeetingFolder(const std::string& path);
  ~MeetingFolder();
  MeetingFolder(const MeetingFolder&) = delete;
  MeetingFolder& operator=(const MeetingFolder&) = delete;

  const std::string& path() const { return path_; }
  /// A new folder that nobody enters yet; its maker removes it.
  static std::string make();

 private:
  std::string path_;
  int owner_ = 0;  ///< the process that removes it; none if it is not its maker
  std::optional<std::string> former_;
};

}  // namespace rubicon::support
