#pragma once

#include <string>

#include "support/meeting_folder.h"

namespace rubicon::support {

/// While it lives this process, and what it starts, is a host of its own: with a network with nothing but loopback, so
/// that fixed ports meet nobody, and a folder where its programs meet. Needs rights that not everybody has; without
/// them entered() is false and nothing is changed.
class PrivateNetwork {
 public:
  PrivateNetwork();
  ~PrivateNetwork();
  PrivateNetwork(const PrivateNetwork&) = delete;
  PrivateNetwork& operator=(const PrivateNetwork&) = delete;

  bool entered() const { return entered_; }
  /// Why not.
  const std::string& reason() const { return reason_; }
  const std::string& folder() const { return folder_.path(); }

 private:
  void leave();

  MeetingFolder folder_;
  int former_ = -1;
  bool entered_ = false;
  std::string reason_;
};

}  // namespace rubicon::support
