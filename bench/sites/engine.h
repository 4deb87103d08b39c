#pragma once

#include "components/node.h"
#include "tuples/mqtt/mqtt_ecology.h"

namespace rubicon::bench::sites {

/// Whom the broker takes all for where it asks for certificates (support::Certificates).
inline constexpr const char* kUser = "rubicon";

tuples::mqtt::SpaceOptions space_options(const Meeting& meeting);
std::shared_ptr<tuples::Ecology> open_at_broker(const Meeting& meeting, transport::Loop& loop, base::LogSink& log);

}  // namespace rubicon::bench::sites
