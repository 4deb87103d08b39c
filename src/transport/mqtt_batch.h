#pragma once

#include <cstddef>
#include <string>

#include "transport/mqtt.h"

namespace rubicon::transport {

/// PUBLISH packets of QoS 0 that leave by one system call. libmosquitto makes two calls for each packet; these are most
/// of what a publisher of small messages costs.
class MqttBatch {
 public:
  /// It takes no more once it has as many bytes.
  static constexpr std::size_t kEnough = std::size_t{64} * 1024;

  /// What the broker said of publications.
  struct Limits {
    bool version_5 = true, retains = true;
    std::size_t largest_packet = 0;  ///< in bytes; 0 = not known
  };

  /// False: the broker does not take so large a packet, and the batch is as before.
  bool add(const MqttPublication& publication, const Limits& limits);
  bool empty() const { return bytes_.empty(); }
  /// Writes as much as the socket takes; without TLS `ssl` is nullptr. False: the connection failed (errno).
  bool write(int socket, void* ssl);

 private:
  std::string bytes_;
  std::size_t written_ = 0;
};

}  // namespace rubicon::transport
