#pragma once

#include <memory>

#include "base/log.h"
#include "base/scheduler.h"
#include "gateway/gateway.h"
#include "model/type_catalogue.h"
#include "proxy/proxy_config.h"
#include "tuples/tuple_space.h"

namespace rubicon::proxy {

/// The island's face in the tuple space: device directory, tuple mirror, demand, command desk (D1.4, chapter 3). A
/// listener of the gateway; attach it before networks start. Everything it takes by reference must outlive it.
class Proxy {
 public:
  Proxy(ProxyConfig config, Scheduler& scheduler, TupleSpace& space, gateway::Gateway& gateway,
        const TypeCatalogue& types, base::LogSink& log);
  ~Proxy();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace rubicon::proxy
