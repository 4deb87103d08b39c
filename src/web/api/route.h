#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "web/api/context.h"
#include "web/api/query.h"
#include "web/api/tuple_read.h"
#include "web/exchange.h"

namespace rubicon::web::api {

/// One request on its way to its answer. The request lives as long as the call of its handler.
struct Call {
  Context& context;
  const Request& request;
  std::vector<std::string> parts;  ///< of the path that stand for the `{...}` of the route, decoded
  Query query;
  Respond respond;

  /// Answers with an error. nullptr.
  std::unique_ptr<Exchange> refuse(const Error& error) const;
  std::unique_ptr<Exchange> answer(Response response) const;
  /// The end of the query, then whether the caller may read what matches.
  Result<void> may_read(const Pattern& pattern);
  /// Answers with what `make` makes of the present tuples of these patterns that the caller may read. kBusy if the
  /// caller read too many; single tuples do not count.
  std::unique_ptr<Exchange> read(const std::vector<Pattern>& patterns, TupleRead::Make make) const;
  /// kBusy: the caller asked for more commands than Context::kCommandsPerSecond.
  Result<void> take_command() const;
  /// The caller, as limits count it.
  std::string caller_name() const;
  /// Whether the client asks for this media type.
  bool accepts(std::string_view media_type) const;
};

/// A parameter of a path or query, as the OpenAPI document describes it.
struct Parameter {
  const char* name;
  const char* type;  ///< of JSON Schema
  const char* about;
  const char* example = "";
  bool required = false;
};

struct RouteAnswer {
  unsigned status;
  const char* media_type;  ///< "" = no body
  const char* about;
};

/// A path and method of the API.
struct Route {
  const char* method;
  const char* path;  ///< `/api/v1/things/{id}`
  const char* summary;
  std::unique_ptr<Exchange> (*handle)(Call& call);
  std::vector<Parameter> parameters{};
  std::vector<RouteAnswer> answers{};
  const char* body = "";  ///< media type of the body of the request; "" = none
  bool is_open = false;   ///< answers callers that are not known, too
};

/// All of them. The OpenAPI document is made of these.
std::span<const Route> routes();
/// The parts of the path for the `{...}` of the route; nullopt if it is another path, or wrongly encoded.
std::optional<std::vector<std::string>> match(const Route& route, std::string_view path);

/// `200 application/json` with the text of the tree.
Response json_response(const nlohmann::ordered_json& tree, unsigned status = 200);
/// Escapes what a query cannot hold (RFC 3986, section 2.1).
std::string percent_encoded(std::string_view text);

/// The id of a component in a path.
Result<OwnerId> owner_of(std::string_view text);
/// Descriptions and statuses of devices, and the lines of their networks.
std::vector<Pattern> device_patterns(std::optional<OwnerId> island);

// The handlers, by file.
std::unique_ptr<Exchange> describe_site(Call& call);
std::unique_ptr<Exchange> list_islands(Call& call);
std::unique_ptr<Exchange> list_devices(Call& call);
std::unique_ptr<Exchange> describe_device(Call& call);
std::unique_ptr<Exchange> list_tuples(Call& call);
std::unique_ptr<Exchange> get_tuple(Call& call);
std::unique_ptr<Exchange> put_tuple(Call& call);
std::unique_ptr<Exchange> list_inbox(Call& call);
std::unique_ptr<Exchange> decide_inbox(Call& call);
std::unique_ptr<Exchange> list_things(Call& call);
std::unique_ptr<Exchange> describe_thing(Call& call);
std::unique_ptr<Exchange> read_history(Call& call);
std::unique_ptr<Exchange> list_series(Call& call);
std::unique_ptr<Exchange> openapi(Call& call);
std::unique_ptr<Exchange> metrics(Call& call);
std::unique_ptr<Exchange> health(Call& call);

}  // namespace rubicon::web::api
