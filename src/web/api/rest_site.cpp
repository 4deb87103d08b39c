#include "rubicon/key.hpp"
#include "web/access/token_file.h"
#include "web/api/route.h"

namespace rubicon::web::api {

std::unique_ptr<Exchange> describe_site(Call& call) {
  const auto& context = call.context;
  const auto& caller = call.request.caller;
  nlohmann::ordered_json tree;
  tree["version"] = "1";
  tree["name"] = context.options.name;
  tree["id"] = number(context.space.self());
  tree["history"] = context.options.history != nullptr;
  tree["tokens"] = context.access.rules().needs_token;
  tree["caller"] = {{"name", caller.name}, {"role", access::to_string(caller.role)}};
  tree["release"] = RUBICON_VERSION;
  if (!context.options.place.empty())
    tree["place"] = {{"text", context.options.place}, {"options", context.options.place_options}};
  return call.answer(json_response(tree));
}

std::unique_ptr<Exchange> health(Call& call) {
  return call.answer({.status = 200, .content_type = "text/plain", .body = "ok\n", .headers = {}, .stream = {}});
}

}  // namespace rubicon::web::api
