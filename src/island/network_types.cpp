#include "island/network_types.h"

#include <array>

#include "networks/dummy/dummy_network.h"
#include "networks/knx/knx_network.h"
#include "networks/log/log_network.h"
#include "networks/salad/salad_network.h"
#include "networks/wsn/wsn_network.h"

namespace rubicon::island {

std::span<const network::NetworkType> network_types() {
  static const std::array kTypes{networks::dummy::kType, networks::log::kType, networks::salad::kType,
                                 networks::knx::kType, networks::wsn::kType};
  return kTypes;
}

}  // namespace rubicon::island
