#include "web/api/route.h"

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
        {"min", "string", "stream: time between two deliveries of a tuple", "100ms"},
        {"max", "string", "stream: deliver present values again after this time"},
        {"deadband", "number", "stream: leave out smaller changes of numbers"},
        {"active", "boolean", "stream: wake the sensors that match"}},
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
        {"ttl", "string", "time to live of the request: 5s if not given"},
        {"wait", "string", "wait for the outcome of a command: 15s if not given"},
        {"sequence", "integer", "refuse unless the tuple has this sequence; 0 = unless there is none"},
        {"user", "number", "time of the measurement, in seconds since 1970"},
        {"lifetime", "string", "the tuple expires after this time"},
        {"append", "boolean", "append to the value"}},
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

}  // namespace rubicon::web::api
