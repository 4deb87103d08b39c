#include "web/api/api.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "web/api/route.h"
#include "web/api/socket.h"
#include "web/exchange.h"

namespace rubicon::web::api {

namespace {

/// No route has this method: what the path has instead.
Response refuse_method(const Request& request, const std::vector<std::string_view>& methods) {
  if (methods.empty())
    return error_response({ErrorCode::kNotFound, fmt::format("no resource {}; /api/v1/openapi.json lists them",
                                                             model::quoted(request.path))});
  const auto all = fmt::format("{}", fmt::join(methods, ", "));
  auto response = error_response(405, ErrorCode::kUnsupported,
                                 fmt::format("{} {}: expected {}", request.method, request.path, all));
  response.headers.emplace_back("Allow", all);
  return response;
}

}  // namespace

Api::Api(Scheduler& scheduler, TupleSpace& space, base::LogSink& log, access::Access& access, ApiOptions options)
    : context_(std::make_unique<Context>(scheduler, space, log, access, std::move(options))) {}

Api::~Api() = default;

std::unique_ptr<Exchange> Api::handle(const Request& request, Respond respond) {
  auto& counters = context_->counters;
  ++counters.requests;
  const auto counted = [&counters, respond = std::move(respond)](Response response) {
    constexpr unsigned kFirstError = 400;
    counters.errors += response.status >= kFirstError;
    respond(std::move(response));
  };
  std::vector<std::string_view> methods;
  for (const auto& route : routes()) {
    auto parts = match(route, request.path);
    if (!parts) continue;
    methods.emplace_back(route.method);
    if (request.method != route.method) continue;
    Call call{*context_, request, std::move(*parts), verbs::Members(request.query), counted};
    if (request.caller.role == Role::kNone && !route.is_open)
      return call.answer(refusal_of({ErrorCode::kRefused, "this needs a token: `Authorization: Bearer TOKEN`"}));
    return route.handle(call);
  }
  counted(refuse_method(request, methods));
  return nullptr;
}

bool Api::takes_file(const Request& request) const {
  return request.caller.role >= Role::kAdmin && std::any_of(routes().begin(), routes().end(), [&](const Route& route) {
           return route.takes_files && request.method == route.method && request.path == route.path;
         });
}

std::unique_ptr<Conversation> Api::open(const Caller& caller, ConversationCallbacks calls) {
  return std::make_unique<Socket>(*context_, caller, std::move(calls));
}

}  // namespace rubicon::web::api
