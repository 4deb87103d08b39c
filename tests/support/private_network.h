#pragma once

#include <string>

namespace rubicon::support {

/// While it lives this process, and what it starts, has a network of its own with nothing but loopback: fixed ports
/// meet nobody. Needs rights that not everybody has; without them entered() is false and nothing is changed.
class PrivateNetwork {
 public:
  PrivateNetwork();
  ~PrivateNetwork();
  PrivateNetwork(const PrivateNetwork&) = delete;
  PrivateNetwork& operator=(const PrivateNetwork&) = delete;

  bool entered() const { return entered_; }
  /// Why not.
  const std::string& reason() const { return reason_; }

 private:
  void leave();

  int former_ = -1;
  bool entered_ = false;
  std::string reason_;
};

}  // namespace rubicon::support
