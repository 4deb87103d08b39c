#include <algorithm>

#include "island/virtual_island.h"
#include "web/api/fake_history.h"
#include "web/api/site.h"

namespace rubicon::web::api {
namespace {

using testing::HasSubstr;
using testing::IsSupersetOf;

/// The API beside an island with the room that the examples of the document name.
struct OpenApi : testing::Test {
  OpenApi() {
    options.history = &history;
    site = std::make_unique<Api>(island.time, *island.space, island.log, access, options);
    island.time.run_for(1s);
  }

  Response ask(const std::string& method, const std::string& target, const std::string& body = "", Fields headers = {},
               Role role = Role::kAdmin) {
    std::optional<Response> response;
    const auto request = Sites::request_of(method, target, body, std::move(headers), role);
    const auto exchange = site->handle(request, [&](Response answer) { response = std::move(answer); });
    for (int i = 0; i < 1200 && !response; ++i) island.time.run_for(50ms);
    EXPECT_TRUE(response) << method << " " << target;
    return response.value_or(Response{0});
  }

  /// The path with the examples of the document.
  static std::string target_of(std::string path, const Json& operation) {
    std::string query;
    for (const auto& parameter : operation.value("parameters", Json::array())) {
      const auto name = parameter["name"].get<std::string>();
      if (!parameter.contains("example")) {
        EXPECT_FALSE(parameter["required"].get<bool>()) << path << ": " << name << " has no example";
        continue;
      }
      const auto example = parameter["example"].get<std::string>();
      if (parameter["in"] == "path") {
        path.replace(path.find("{" + name + "}"), name.size() + 2, example);
      } else {
        query += (query.empty() ? "?" : "&") + name + "=" + example;
      }
    }
    return path + query;
  }

  static void expect_documented(const Response& response, const Json& operation, const std::string& what) {
    const auto status = std::to_string(response.status);
    ASSERT_TRUE(operation["responses"].contains(status)) << what << " answers " << status << ": " << response.body;
    const auto& documented = operation["responses"][status];
    if (!documented.contains("content")) return;
    EXPECT_TRUE(documented["content"].contains(response.content_type)) << what << ": " << response.content_type;
    if (!response.content_type.ends_with("json")) return;
    const auto body = Json::parse(response.body, nullptr, false);
    ASSERT_TRUE(body.is_object()) << what;
    const bool is_error = response.status >= 400;
    EXPECT_EQ(is_error, body.contains("error")) << what;
  }

  island::VirtualIsland island{"{room: {sensors: {light-1: {}}, actuators: {lamp-1: {}}}}"};
  FakeHistory history{island.time};
  access::Access access{island.time, {}};
  ApiOptions options{"hall"};
  std::unique_ptr<Api> site;
};

TEST_F(OpenApi, EachPathAndMethodAnswersAsTheDocumentSays) {
  const auto document = Json::parse(ask("GET", "/api/v1/openapi.json").body);
  EXPECT_EQ(document["openapi"], "3.1.0");
  std::vector<std::string> paths;
  for (const auto& [path, operations] : document["paths"].items()) {
    paths.push_back(path);
    for (const auto& [method, operation] : operations.items()) {
      const auto what = method + " " + path;
      std::string upper = method;
      std::transform(upper.begin(), upper.end(), upper.begin(),
                     [](char c) { return static_cast<char>(c - 'a' + 'A'); });
      const std::string body = method == "post" ? R"({"approve":"dummy-1.*"})" : method == "put" ? "on" : "";
      const auto target = target_of(path, operation);
      const auto good = ask(upper, target, body);
      expect_documented(good, operation, what);
      EXPECT_TRUE(method != "get" || good.status == 200) << what << good.body;
      island.time.run_for(1s);
      const auto wrong = ask(upper, target + (target.find('?') == target.npos ? "?" : "&") + "wrong=1", body);
      expect_documented(wrong, operation, what);
      EXPECT_EQ(operation["responses"].contains("400"), wrong.status == 400) << what;
      const auto unknown = ask(upper, target, body, {}, Role::kNone);
      EXPECT_EQ(unknown.status, operation.contains("security") ? 200U : 401U) << what;
      island.time.run_for(1s);
    }
  }
  EXPECT_THAT(paths, IsSupersetOf({"/api/v1", "/api/v1/islands", "/api/v1/devices", "/api/v1/tuples", "/api/v1/inbox",
                                   "/api/v1/history", "/api/v1/things", "/metrics", "/healthz"}));
}

TEST_F(OpenApi, OtherMediaTypesOfTheDocumentAreAnsweredToo) {
  const auto document = Json::parse(ask("GET", "/api/v1/openapi.json").body);
  for (const auto& [path, operations] : document["paths"].items()) {
    if (!operations.contains("get")) continue;
    for (const auto& [type, unused] : operations["get"]["responses"]["200"]["content"].items()) {
      const auto response = ask("GET", target_of(path, operations["get"]), "", {{"accept", type}});
      EXPECT_EQ(response.content_type, type) << path;
      island.time.run_for(1s);
    }
  }
}

TEST_F(OpenApi, AThingHasItsPointsAsProperties) {
  const auto response = ask("GET", "/api/v1/things/6541:proxy.dummy-1.room");
  EXPECT_EQ(response.content_type, "application/td+json");
  const auto thing = Json::parse(response.body);
  EXPECT_EQ(thing["@context"][0], "https://www.w3.org/2022/wot/td/v1.1");
  EXPECT_EQ(thing["id"], "urn:rubicon:6541:proxy.dummy-1.room");
  EXPECT_EQ(thing["security"], Json::array({"nosec_sc"}));
  EXPECT_EQ(thing["securityDefinitions"]["nosec_sc"]["scheme"], "nosec");
  const auto& light = thing["properties"]["sensor.light-1"];
  EXPECT_EQ(light["type"], "number");
  EXPECT_EQ(light["unit"], "lx");
  EXPECT_EQ(light["readOnly"], true);
  EXPECT_EQ(light["forms"].size(), 2U);
  EXPECT_EQ(light["forms"][0]["href"], "/api/v1/tuples/6541/proxy.dummy-1.room.sensor.light-1.value");
  EXPECT_EQ(light["forms"][1]["subprotocol"], "sse");
  const auto& lamp = thing["properties"]["actuator.lamp-1"];
  EXPECT_EQ(lamp["readOnly"], false);
  ASSERT_EQ(lamp["forms"].size(), 3U);
  EXPECT_EQ(lamp["forms"][2]["op"], Json::array({"writeproperty"}));
  EXPECT_EQ(ask("PUT", lamp["forms"][2]["href"], "on").status, 200U);
  const auto read = ask("GET", lamp["forms"][0]["href"], "", {{"accept", lamp["forms"][0]["contentType"]}});
  EXPECT_EQ(read.body, "on");
}

}  // namespace
}  // namespace rubicon::web::api
