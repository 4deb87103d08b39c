#include "web/api/api.h"

#include <fmt/format.h>

#include <utility>

#include "model/json_members.h"
#include "web/api/socket.h"
#include "web/error_response.h"

namespace rubicon::web::api {

struct Api::Impl {
  Impl(Scheduler& scheduler, TupleSpace& space, base::LogSink& log, access::Access& access, ApiOptions its_options)
      : context(scheduler, space, log, access), options(std::move(its_options)) {}

  Response describe(const Caller& caller) const {
    nlohmann::ordered_json tree;
    tree["version"] = 1;
    tree["name"] = options.name;
    tree["id"] = number(context.space.self());
    tree["history"] = false;
    tree["tokens"] = context.access.rules().needs_token;
    tree["caller"] = {{"name", caller.name}, {"role", access::to_string(caller.role)}};
    tree["release"] = RUBICON_VERSION;
    return {200, "application/json", model::dump(tree)};
  }

  Context context;
  ApiOptions options;
};

Api::Api(Scheduler& scheduler, TupleSpace& space, base::LogSink& log, access::Access& access, ApiOptions options)
    : impl_(std::make_unique<Impl>(scheduler, space, log, access, std::move(options))) {}

Api::~Api() = default;

std::unique_ptr<Exchange> Api::handle(const Request& request, Respond respond) {
  ++impl_->context.counters.requests;
  if (request.method == "GET" && request.path == "/healthz") {
    respond({200, "text/plain", "ok\n"});
  } else if (request.method == "GET" && request.path == "/api/v1") {
    respond(impl_->describe(request.caller));
  } else {
    respond(error_response({ErrorCode::kNotFound, fmt::format("no resource {}", model::quoted(request.path))}));
  }
  return nullptr;
}

std::unique_ptr<Conversation> Api::open(const Caller& caller, ConversationCalls calls) {
  return std::make_unique<Socket>(impl_->context, caller, std::move(calls));
}

}  // namespace rubicon::web::api
