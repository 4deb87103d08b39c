#include "support/meeting_folder.h"

#include <unistd.h>

#include <cstdlib>
#include <filesystem>

namespace rubicon::support {

namespace {

constexpr const char* kVariable = "RUBICON_FOLDER";

}  // namespace

/// Short, because the path of a socket has 107 bytes at most.
std::string MeetingFolder::make() {
  auto path = (std::filesystem::temp_directory_path() / "rmXXXXXX").string();
  if (::mkdtemp(path.data()) == nullptr) std::abort();
  return path;
}

MeetingFolder::MeetingFolder() : MeetingFolder(make()) {
  owner_ = ::getpid();
}

MeetingFolder::MeetingFolder(const std::string& path) : path_(path) {
  if (const auto* former = std::getenv(kVariable)) former_ = former;
  ::setenv(kVariable, path_.c_str(), 1);
}

MeetingFolder::~MeetingFolder() {
  if (former_) {
    ::setenv(kVariable, former_->c_str(), 1);
  } else {
    ::unsetenv(kVariable);
  }
  std::error_code ignored;
  if (owner_ == ::getpid()) std::filesystem::remove_all(path_, ignored);
}

}  // namespace rubicon::support
