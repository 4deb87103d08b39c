#pragma once

#include <chrono>
#include <optional>
#include <string>

namespace rubicon::install {

/// The service manager's end of sd_notify(3): a datagram socket in the file system.
class NoticeSocket {
 public:
  explicit NoticeSocket(std::string path);
  ~NoticeSocket();
  NoticeSocket(const NoticeSocket&) = delete;
  NoticeSocket& operator=(const NoticeSocket&) = delete;

  const std::string& path() const { return path_; }
  /// The next notice, if one comes in this time.
  std::optional<std::string> next(std::chrono::milliseconds patience);
  /// The next notice that contains this; empty after 20 s without one.
  std::string next_with(const std::string& part);

 private:
  std::string path_;
  int socket_ = -1;
};

}  // namespace rubicon::install
