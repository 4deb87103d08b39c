#include "web/api/route.h"

#include <array>
#include <string>

#include "model/json_members.h"

namespace rubicon::web::api {

namespace {

constexpr const char* kJson = "application/json";
constexpr const char* kOwner = "the id of a component, such as 6541";

const Parameter kAfter{"after", "string", "begin behind this entry, which `next` of the page before names"};
const Parameter kLimit{"limit", "integer", "entries of a page, 1 to 1000", "100"};
const Parameter kPathOwner{"owner", "integer", kOwner, "6541", true};
const Parameter kPathKey{"key", "string", "the key of a tuple", "proxy.island", true};

const RouteAnswer kInvalid{400, kJson, "the request is wrong; the text says what was expected"};
const RouteAnswer kRefused{403, kJson, "the role or the rights of the caller do not permit it"};
const RouteAnswer kNone{404, kJson, "there is none"};
const RouteAnswer kBusy{429, kJson, "too often; try again later"};

std::vector<Route> site_routes() {
  return {
      {"GET", "/api/v1", "Version, component, caller, and what is on", describe_site, {}, {{200, kJson, "the site"}}},
      {"GET", "/api/v1/islands", "The islands that are present", list_islands, {}, {{200, kJson, "islands"}, kInvalid}},
      {"GET", "/api/v1/openapi.json", "This document (OpenAPI 3.1)", openapi, {}, {{200, kJson, "the document"}}},
      {"GET",
       "/metrics",
       "Counters and states for Prometheus (text format 0.0.4)",
       metrics,
       {},
       {{200, "text/plain; version=0.0.4", "metrics"}, kInvalid, kBusy}},
      {"GET", "/healthz", "200 while the event loop turns", health, {}, {{200, "text/plain", "ok"}}, "", true},
  };
}

std::vector<Route> device_routes() {
  return {
      {"GET",
       "/api/v1/devices",
       "Devices of all islands, by island and key",
       list_devices,
       {{"island", "integer", "of this island"},
        {"network", "string", "id of the network, with * and ?", "dummy*"},
        {"type", "string", "type of the device or of one of its points, with * and ?"},
        {"name", "string", "name, id or address, with * and ?"},
        {"area", "string", "room or place, with * and ?"},
        kAfter,
        kLimit},
       {{200, kJson, "a page of devices"}, kInvalid, kRefused, kBusy}},
      {"GET",
       "/api/v1/devices/{island}/{network}/{device}",
       "A device with its points, their values and states",
       describe_device,
       {{"island", "integer", "id of the island", "6541", true},
        {"network", "string", "id of the network", "dummy-1", true},
        {"device", "string", "key part of the device", "room", true}},
       {{200, kJson, "the device"}, kInvalid, kRefused, kNone, kBusy}},
      {"GET",
       "/api/v1/inbox",
       "Devices that wait for a decision, and ignored ones",
       list_inbox,
       {kAfter, kLimit},
       {{200, kJson, "a page of devices; state is waiting or ignored"}, kInvalid, kRefused, kBusy}},
      {"POST",
       "/api/v1/inbox",
       "Approve or ignore devices: {\"approve\": \"wsn-1.*\", \"island\": 6541}, or lists of at most 1,000",
       decide_inbox,
       {},
       {{200, kJson, "done; of a list at least one, and what became of each"},
        kInvalid,
        kRefused,
        kNone,
        {409, kJson, "the island refused"},
        kBusy,
        {504, kJson, "the island did not answer"}},
       kJson},
      {"POST",
       "/api/v1/import",
       "What a KNX project (.knxproj) or export (CSV, XML, ESF) becomes: the points, the report, and a group file. "
       "Changes nothing",
       preview_import,
       {{"name", "string", "of the file", "flat.csv"},
        {"network", "string", "id of the network that gets it", "knx-hall"},
        {"no-guess", "boolean", "names decide nothing"}},
       {{200, kJson, "the preview"}, kInvalid, kRefused, kBusy, {501, kJson, "this server belongs to no island"}},
       "application/octet-stream",
       false,
       true},
      {"GET",
       "/api/v1/things",
       "Devices as W3C Thing Descriptions 1.1",
       list_things,
       {kAfter, kLimit},
       {{200, kJson, "a page of descriptions"}, kInvalid, kRefused, kBusy}},
      {"GET",
       "/api/v1/things/{id}",
       "One Thing Description",
       describe_thing,
       {{"id", "string", "ISLAND:KEY of the device", "6541:proxy.dummy-1.room", true}},
       {{200, "application/td+json", "the description"}, kInvalid, kRefused, kNone, kBusy}},
  };
}

std::vector<Route> tuple_routes() {
  return {
      {"GET",
       "/api/v1/tuples",
       "Present tuples by pattern; with `Accept: text/event-stream` each change, too",
       list_tuples,
       {{"pattern", "string", "OWNER:KEY or *:KEY, with * and **", "6541:proxy.*", true},
        kAfter,
        kLimit,
        {"min", "string", "stream: least time between two deliveries of a tuple", "100ms"},
        {"max", "string", "stream: deliver present values again after this time"},
        {"deadband", "number", "stream: leave out smaller changes of numbers"},
        {"active", "boolean", "stream: wake the sensors that match"},
        {"passive", "boolean", "stream: wake none, as if `active` were not given"},
        {"full", "boolean", "no difference here: each tuple comes with all that is known of it"}},
       {{200, kJson, "a page of tuples"}, {200, "text/event-stream", "changes"}, kInvalid, kRefused, kBusy}},
      {"GET",
       "/api/v1/tuples/{owner}/{key}",
       "One tuple; `Accept: text/plain` or `raw`: the value alone",
       get_tuple,
       {kPathOwner,
        kPathKey,
        {"raw", "boolean", "the bytes of the value, with its media type"},
        {"sequence", "integer", "not read: makes the address of each value another one"}},
       {{200, kJson, "the tuple"}, {200, "text/plain", "the value"}, kInvalid, kRefused, kNone}},
      {"PUT",
       "/api/v1/tuples/{owner}/{key}",
       "Set a tuple; of a command, wait for the outcome",
       put_tuple,
       {kPathOwner,
        kPathKey,
        {"do", "string", "set or append: set if not given"},
        {"ttl", "string", "time to live of the request: 5s if not given"},
        {"wait", "string", "wait for the outcome of a command: 15s if not given"},
        {"sequence", "integer", "refuse unless the tuple has this sequence; 0 = unless there is none"},
        {"user", "string", "time of the measurement, in seconds since 1970, or a time from now: -2min"},
        {"expire", "string", "when the tuple expires, likewise: 1h"}},
       {{200, kJson, "confirmed, assumed or applied"},
        {202, kJson, "queued or sent"},
        kInvalid,
        kRefused,
        kNone,
        {409, kJson, "refused or superseded"},
        kBusy,
        {502, kJson, "failed"},
        {504, kJson, "timed-out or expired"}},
       "text/plain"},
  };
}

std::vector<Route> history_routes() {
  return {
      {"GET",
       "/api/v1/history",
       "Past values, in buckets; `Accept: text/csv`",
       read_history,
       {{"key", "string", "OWNER:KEY; may be given up to 32 times", "6541:proxy.dummy-1.room.sensor.light-1.value",
         true},
        {"from", "string", "seconds since 1970, or a time before now: -1h", "-1h"},
        {"to", "string", "the same; now if not given"},
        {"buckets", "integer", "at most so many values of each series, 1 to 5000", "100"}},
       {{200, kJson, "the past"}, {200, "text/csv", "the past as a table"}, kInvalid, kRefused, kNone, kBusy}},
      {"GET",
       "/api/v1/history/series",
       "The series that are kept",
       list_series,
       {{"pattern", "string", "OWNER:KEY or *:KEY, with * and **"}, kAfter, kLimit},
       {{200, kJson, "a page of series"}, kInvalid, kRefused, kNone, kBusy}},
  };
}

}  // namespace

std::span<const Route> routes() {
  static const auto kAll = [] {
    std::vector<Route> all;
    for (auto& some : {site_routes(), device_routes(), tuple_routes(), history_routes()})
      all.insert(all.end(), some.begin(), some.end());
    return all;
  }();
  return kAll;
}

namespace {

using Json = nlohmann::ordered_json;

bool is_in_path(const Route& route, const Parameter& parameter) {
  return std::string_view(route.path).find("{" + std::string(parameter.name) + "}") != std::string_view::npos;
}

Json parameter_json(const Route& route, const Parameter& parameter) {
  Json tree;
  tree["name"] = parameter.name;
  tree["in"] = is_in_path(route, parameter) ? "path" : "query";
  tree["required"] = parameter.required;
  tree["description"] = parameter.about;
  tree["schema"] = {{"type", parameter.type}};
  if (*parameter.example != '\0') tree["example"] = parameter.example;
  return tree;
}

Json responses_json(const Route& route) {
  Json responses;
  for (const auto& answer : route.answers) {
    auto& response = responses[std::to_string(answer.status)];
    if (!response.contains("description")) response["description"] = answer.about;
    const bool is_error = answer.status >= 400;
    const Json schema = is_error ? Json{{"$ref", "#/components/schemas/Error"}} : Json::object();
    response["content"][answer.media_type] = {{"schema", schema}};
  }
  if (!route.is_open) responses["401"] = {{"$ref", "#/components/responses/NoToken"}};
  return responses;
}

Json operation_json(const Route& route) {
  Json operation;
  operation["summary"] = route.summary;
  for (const auto& parameter : route.parameters) operation["parameters"].push_back(parameter_json(route, parameter));
  if (*route.body != '\0')
    operation["requestBody"] = {{"required", true}, {"content", {{route.body, {{"schema", Json::object()}}}}}};
  operation["responses"] = responses_json(route);
  if (route.is_open) operation["security"] = Json::array();
  return operation;
}

Json components_json() {
  Json error;
  error["type"] = "object";
  error["required"] = {"error"};
  error["properties"]["error"] = {{"type", "object"},
                                  {"required", {"code", "text"}},
                                  {"properties", {{"code", {{"type", "string"}}}, {"text", {{"type", "string"}}}}}};
  Json components;
  components["schemas"]["Error"] = error;
  components["responses"]["NoToken"] = {
      {"description", "a token is needed"},
      {"content", {{"application/json", {{"schema", {{"$ref", "#/components/schemas/Error"}}}}}}}};
  components["securitySchemes"]["bearer"] = {{"type", "http"}, {"scheme", "bearer"}};
  return components;
}

std::string document(bool needs_token) {
  Json tree;
  tree["openapi"] = "3.1.0";
  tree["info"] = {{"title", "Rubicon"}, {"version", "1"}};
  tree["servers"] = {{{"url", "/"}}};
  for (const auto& route : routes()) {
    std::string method = route.method;
    for (auto& c : method) c = static_cast<char>(c - 'A' + 'a');
    tree["paths"][route.path][method] = operation_json(route);
  }
  tree["components"] = components_json();
  if (needs_token) tree["security"] = {{{"bearer", Json::array()}}};
  return model::dump(tree);
}

}  // namespace

/// It is the same as long as the program runs.
std::unique_ptr<Exchange> openapi(Call& call) {
  static const std::array<std::string, 2> kDocuments{document(false), document(true)};
  return call.answer({.status = 200,
                      .content_type = "application/json",
                      .body = kDocuments[call.context.access.rules().needs_token ? 1 : 0]});
}

}  // namespace rubicon::web::api
