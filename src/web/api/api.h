#pragma once

#include <memory>

#include "base/log.h"
#include "web/api/context.h"
#include "web/exchange.h"

namespace rubicon::web::api {

/// The application behind HTTP and WebSocket: the tuple space for programs and the page (docs/api.md). It knows no
/// sockets. All that it is constructed with must outlive it, and it must outlive its exchanges and conversations.
class Api final : public Site {
 public:
  Api(Scheduler& scheduler, TupleSpace& space, base::LogSink& log, access::Access& access, ApiOptions options = {});
  ~Api() override;

  std::unique_ptr<Exchange> handle(const Request& request, Respond respond) override;
  bool takes_file(const Request& request) const override;
  std::unique_ptr<Conversation> open(const Caller& caller, ConversationCallbacks calls) override;

 private:
  std::unique_ptr<Context> context_;
};

}  // namespace rubicon::web::api
