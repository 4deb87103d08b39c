#pragma once

#include "rubicon/client.hpp"
#include "tuples/peis/peis_ecology.h"

namespace rubicon::client {

/// What the component of this process sees of its PEIS network.
PeisView view_of(const tuples::peis::PeisEcology& ecology);

}  // namespace rubicon::client
