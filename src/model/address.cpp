#include "rubicon/address.hpp"

#include <fmt/format.h>

namespace rubicon::model {

std::string to_string(const Address& address) {
  auto text = fmt::format("{}", number(address.island));
  if (!address.network.empty()) text += '/' + address.network;
  if (!address.device.empty()) text += '/' + address.device;
  return text;
}

}  // namespace rubicon::model
