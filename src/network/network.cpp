#include "network/network.h"

#include <utility>

namespace rubicon::network {

void NetworkHost::deliver(std::string device, model::Body body) {
  Message message;
  message.source.device = std::move(device);
  message.body = std::move(body);
  deliver(std::move(message));
}

}  // namespace rubicon::network
