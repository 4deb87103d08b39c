#pragma once

#include <mosquitto.h>

#include <cstdint>
#include <string>

namespace rubicon::bench::mqtt {

/// A client of libmosquitto and nothing else, in this thread: connects and publishes. It spends nothing on a loop of
/// its own: what a broker sends is not read.
class BarePublisher {
 public:
  /// Connects to a broker of this host in version 5. Throws.
  explicit BarePublisher(std::uint16_t port);
  ~BarePublisher();
  BarePublisher(const BarePublisher&) = delete;
  BarePublisher& operator=(const BarePublisher&) = delete;

  /// Retained, QoS 0. Throws.
  void publish(const std::string& topic, const std::string& payload);

 private:
  mosquitto* client_ = nullptr;
  bool accepted_ = false;
};

}  // namespace rubicon::bench::mqtt
