#include <fmt/format.h>

#include <map>

#include "base/text.h"
#include "client/json_forms.h"
#include "client/points.h"
#include "model/point_keys.h"
#include "rubicon/key.hpp"
#include "web/access/token_file.h"
#include "web/api/forms.h"
#include "web/api/route.h"
#include "web/exchange.h"

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

namespace {

std::string name_of_device(const client::Device& device) {
  return fmt::format("{}:{}", number(device.island), device.key());
}

client::DeviceQuery device_query(verbs::Members& query) {
  client::DeviceQuery wanted;
  if (const auto island = query.count("island", 1, model::kMaxIslandId))
    wanted.island = OwnerId(static_cast<std::uint32_t>(*island));
  wanted.network = query.text_or("network", "");
  wanted.type = query.text_or("type", "");
  wanted.name = query.text_or("name", "");
  wanted.area = query.text_or("area", "");
  return wanted;
}

/// The points of a device, each with what its tuples say.
nlohmann::ordered_json points_json(const client::Device& device, const std::vector<client::Tuple>& tuples) {
  std::map<std::string_view, std::string_view> texts;
  for (const auto& tuple : tuples) texts[tuple.key] = tuple.value;
  auto points = nlohmann::ordered_json::array();
  for (const auto& place : client::places_of(device)) {
    const auto key = model::DeviceKey{device.key()}.point(place.kind, place.id);
    points.push_back(client::place_json(
        device, place,
        {std::string(texts[key.value()]), std::string(texts[key.status()]), std::string(texts[key.description()])}));
  }
  return points;
}

}  // namespace

Result<OwnerId> owner_of(std::string_view text) {
  const auto id = base::parse_number<std::uint32_t>(text);
  if (id && *id != 0) return OwnerId(*id);
  return fail(ErrorCode::kInvalid,
              fmt::format("{} in the path: expected the number of a component", model::quoted(text)));
}

std::vector<Pattern> device_patterns(std::optional<OwnerId> island) {
  const auto any_network = model::IslandKey{"*"}.network("*");
  const auto any_device = any_network.device("*");
  return {{island, any_device.description()}, {island, any_device.status()}, {island, any_network.status()}};
}

std::unique_ptr<Exchange> list_islands(Call& call) {
  if (auto good = call.may_read({std::nullopt, "**"}); !good) return call.refuse(good.error());
  return call.answer(json_response({{"islands", components_json(call.context.space, true)}}));
}

std::unique_ptr<Exchange> list_devices(Call& call) {
  const auto wanted = device_query(call.query);
  const auto range = read_range(call.query);
  if (auto good = call.may_read({wanted.island, "**"}); !good) return call.refuse(good.error());
  for (const auto& pattern : device_patterns({})) call.context.recent_reads.keep(pattern);
  return call.read(device_patterns(wanted.island),
                   [wanted, range, request = call.request](const std::vector<client::Tuple>& tuples) {
                     return json_response(page_of("devices", client::devices_from(tuples, wanted), request, range,
                                                  name_of_device, client::device_json));
                   });
}

std::unique_ptr<Exchange> describe_device(Call& call) {
  const auto island = owner_of(call.parts[0]);
  if (!island) return call.refuse(island.error());
  const auto key = fmt::format("*.{}.{}", call.parts[1], call.parts[2]);
  if (auto good = Pattern::parse(key); !good) return call.refuse(good.error());
  const Pattern all{*island, key + ".**"};
  if (auto good = call.may_read(all); !good) return call.refuse(good.error());
  const Pattern line{*island, fmt::format("*.{}.status", call.parts[1])};
  const auto name = fmt::format("{}/{}/{}", call.parts[0], call.parts[1], call.parts[2]);
  return call.read(std::vector{all, line}, [name](const std::vector<client::Tuple>& tuples) {
    const auto found = client::devices_from(tuples, {});
    if (found.empty()) return error_response({ErrorCode::kNotFound, fmt::format("no device {}", name)});
    auto tree = client::device_json(found.front());
    tree["points"] = points_json(found.front(), tuples);
    return json_response(tree);
  });
}

}  // namespace rubicon::web::api
