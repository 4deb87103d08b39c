#include <fmt/format.h>

#include "client/points.h"
#include "model/point_keys.h"
#include "web/api/page_of.h"
#include "web/api/route.h"
#include "web/api/thing.h"
#include "web/api/tuple_read.h"
#include "web/error_response.h"

namespace rubicon::web::api {

namespace {

constexpr const char* kThingType = "application/td+json";

std::string id_of_thing(const client::Device& device) {
  return fmt::format("{}:{}", number(device.island), device.key());
}

}  // namespace

std::unique_ptr<Exchange> list_things(Call& call) {
  const auto range = read_range(call.query);
  if (auto good = call.may_read({std::nullopt, "**"}); !good) return call.refuse(good.error());
  auto patterns = device_patterns({});
  patterns.push_back({std::nullopt, model::any_point().description()});
  for (const auto& pattern : patterns) call.context.recent_reads.keep(pattern);
  const bool needs_token = call.context.access.rules().needs_token;
  return call.read(patterns, [range, needs_token, request = call.request](const std::vector<client::Tuple>& tuples) {
    std::map<OwnerId, PointDescriptions> points;
    const auto describe = [&](const client::Device& device) {
      const auto known = points.find(device.island);
      if (known == points.end()) points[device.island] = point_descriptions(tuples, device.island);
      return thing_description(device, points[device.island], needs_token);
    };
    return json_response(page_of("things", client::devices_from(tuples, {}), request, range, id_of_thing, describe));
  });
}

std::unique_ptr<Exchange> describe_thing(Call& call) {
  std::string_view id = call.parts[0];
  constexpr std::string_view kUrn = "urn:rubicon:";
  if (id.starts_with(kUrn)) id.remove_prefix(kUrn.size());
  const auto device = Pattern::parse(id);
  if (!device || !device->owner || !device->exact())
    return call.refuse(
        {ErrorCode::kInvalid, fmt::format("thing {}: expected an id such as 6541:proxy.wsn-1.7", model::quoted(id))});
  const Pattern all{device->owner, device->key + ".**"};
  if (auto good = call.may_read(all); !good) return call.refuse(good.error());
  const bool needs_token = call.context.access.rules().needs_token;
  return call.read(std::vector{all}, [needs_token, id = *device](const std::vector<client::Tuple>& tuples) {
    const auto found = client::devices_from(tuples, {});
    if (found.size() != 1 || found.front().key() != id.key)
      return error_response({ErrorCode::kNotFound, fmt::format("no thing {}", to_string(id))});
    auto thing = thing_description(found.front(), point_descriptions(tuples, *id.owner), needs_token);
    auto response = json_response(thing);
    response.content_type = kThingType;
    return response;
  });
}

}  // namespace rubicon::web::api
