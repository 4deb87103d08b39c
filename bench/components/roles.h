#pragma once

#include "components/processes.h"

namespace rubicon::bench {

inline constexpr int kJoinedDevices = 1000, kJoinedSensors = 100;  ///< of the island that joiner() subscribes to

// What the processes of the measurements do, over any engine.
Json ping(const Meeting& meeting, const Json& options);
Json pong(const Meeting& meeting, const Json& options);
Json writer(const Meeting& meeting, const Json& options);
Json sink(const Meeting& meeting, const Json& options);
Json commander(const Meeting& meeting, const Json& options);
Json desk(const Meeting& meeting, const Json& options);
Json island(const Meeting& meeting, const Json& options);
Json joiner(const Meeting& meeting, const Json& options);
Json one_of_many(const Meeting& meeting, const Json& options);
Json paced_writer(const Meeting& meeting, const Json& options);
Json follower(const Meeting& meeting, const Json& options);
Json watched(const Meeting& meeting, const Json& options);
Json watcher(const Meeting& meeting, const Json& options);

/// Of one of many tuples of a writer, with six parts.
std::string load_key(std::size_t index);

}  // namespace rubicon::bench
