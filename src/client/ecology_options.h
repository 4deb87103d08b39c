#pragma once

#include <memory>

#include "base/log.h"
#include "rubicon/client.hpp"
#include "trust/site/live_realm.h"
#include "tuples/engines/engines.h"

namespace rubicon::client {

/// The users and members at the broker of the options; nullptr: the options name no authority of a realm. The errors of
/// LiveRealm::open().
Result<std::shared_ptr<trust::site::LiveRealm>> open_realm(const Options& options, Scheduler& scheduler,
                                                           base::LogSink& log);
/// The id of the options, else a random one that no island has, for all engines.
OwnerId component_id(const Options& options);

/// kInvalid with what is wrong.
Result<void> check(const Options& options);

/// What to say about a domain or a tag that became a space; empty = nothing.
std::string old_space_warning(const Options& options);

bool has_engine(const Options& options, Engine engine);
/// How the engines find the components that the options mean. kInvalid: the folder or the space.
Result<tuples::engines::EngineOptions> engine_options(const Options& options);

}  // namespace rubicon::client
