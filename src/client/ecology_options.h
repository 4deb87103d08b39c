#pragma once

#include "rubicon/client.hpp"
#include "tuples/engines/engines.h"

namespace rubicon::client {

/// A random id that no island has, for all engines.
OwnerId random_component_id();

/// kInvalid with what is wrong.
Result<void> check(const Options& options);

bool has_engine(const Options& options, Engine engine);
/// How the engines find the components that the options mean. The options passed check().
tuples::engines::EngineOptions engine_options(const Options& options);

}  // namespace rubicon::client
