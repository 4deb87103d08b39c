#pragma once

#include "rubicon/client.hpp"
#include "tuples/dds/dds_options.h"

namespace rubicon::client {

/// A random id that no island has.
OwnerId random_component_id();

/// kInvalid with what is wrong.
Result<void> check(const Options& options);

/// How the engine finds the components that the options mean.
tuples::dds::DdsOptions dds_options(const Options& options);

}  // namespace rubicon::client
