#include "apps/rubicon-proxy/knx_importer.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "support/knx_project.h"

namespace rubicon::daemon {
namespace {

using nlohmann::json;
using testing::HasSubstr;

constexpr const char* kCsv =
    "\"Group name\";\"Address\";\"Central\";\"Unfiltered\";\"Description\";\"DatapointType\";\"Security\"\n"
    "\"Light\";\"1/-/-\";\"\";\"\";\"\";\"\";\"Auto\"\n"
    "\"Hall\";\"1/0/-\";\"\";\"\";\"\";\"\";\"Auto\"\n"
    "\"Ceiling switch\";\"1/0/1\";\"\";\"\";\"\";\"DPST-1-1\";\"Auto\"\n"
    "\"Ceiling status\";\"1/0/2\";\"\";\"\";\"\";\"DPST-1-1\";\"Auto\"\n"
    "\"Outside\";\"1/0/3\";\"\";\"\";\"\";\"DPT-9\";\"Auto\"\n"
    "\"What is it\";\"1/0/4\";\"\";\"\";\"\";\"\";\"Auto\"\n"
    "\"Beyond\";\"99/0/4\";\"\";\"\";\"\";\"\";\"Auto\"\n";

web::ImportRequest upload(std::string name, std::string content) {
  web::ImportRequest request;
  request.name = std::move(name);
  request.content = std::move(content);
  request.network = "knx-hall";
  return request;
}

json preview(web::ImportRequest request, const std::string& known = "") {
  const auto made = preview_of(std::move(request), known);
  return made ? json::parse(*made) : json{{"error", made.error().text}, {"code", to_string(made.error().code)}};
}

std::string error(web::ImportRequest request) {
  return preview(std::move(request)).value("error", "(none)");
}

TEST(KnxImporter, EachAddressSaysWhatItBecomesAndWhatIsUncertain) {
  const auto got = preview(upload("flat.csv", kCsv));
  ASSERT_EQ(got["points"].size(), 3U) << got;
  const auto& lamp = got["points"][0];
  EXPECT_EQ(lamp["address"], "1/0/1");
  EXPECT_EQ(lamp["state"], "1/0/2");
  EXPECT_EQ(lamp["name"], "Ceiling switch");
  EXPECT_EQ(lamp["dpt"], "1.001");
  EXPECT_EQ(lamp["kind"], "actuator");
  EXPECT_EQ(lamp["point"], "1_0_1.actuator.switch-1");
  EXPECT_THAT(lamp["notes"].dump(), HasSubstr("1/0/2")) << "inferred from names";
  EXPECT_EQ(got["points"][1]["dpt"], "9.*");
  EXPECT_EQ(got["points"][2]["dpt"], "");
  EXPECT_EQ(got["points"][2]["point"], "1_0_4.sensor.bytesInput-1");
  EXPECT_EQ(got["counts"]["errors"], 1);
  ASSERT_EQ(got["findings"].size(), 1U) << got["findings"];
  EXPECT_EQ(got["findings"][0]["level"], "error");
  EXPECT_EQ(got["findings"][0]["line"], 8);
  EXPECT_GT(got["types"].size(), 300U);
  EXPECT_THAT(got["groups"].get<std::string>(), HasSubstr("1/0/1: {dpt: 1.001, kind: actuator, state: 1/0/2"));
}

TEST(KnxImporter, ChoicesChangeTypesAndKindsAndLeaveOut) {
  auto request = upload("groups.yaml", preview(upload("flat.csv", kCsv))["groups"]);
  request.choices = R"({"1/0/3":{"dpt":"9.001"},"1/0/4":{"dpt":"1.001","kind":"actuator"},"1/0/1":{"leave":true}})";
  const auto got = preview(request);
  ASSERT_EQ(got["points"].size(), 2U) << got;
  EXPECT_EQ(got["points"][0]["point"], "1_0_3.sensor.temperature-1");
  EXPECT_EQ(got["points"][0]["unit"], "Cel");
  EXPECT_EQ(got["points"][1]["point"], "1_0_4.actuator.switch-1");
  EXPECT_FALSE(got.contains("types"));
  for (const auto* wrong :
       {R"({"1/0/3":{"dpt":"77.1"}})", R"({"1/0/3":{"kind":"lamp"}})", R"({"1/0/9":{"dpt":"9.001"}})",
        R"({"x":{"dpt":"9.001"}})", R"({"1/0/1":{"kind":"sensor"}})"}) {
    request.choices = wrong;
    EXPECT_THAT(error(request), HasSubstr("choices: ")) << wrong;
  }
}

TEST(KnxImporter, TheGroupFileOfTheNetworkKeepsItsNames) {
  const auto got = preview(upload("flat.csv", kCsv),
                           "groups:\n  1/0/3: {dpt: 9.001, kind: sensor, device: roof, instance: north, name: Old}\n");
  EXPECT_EQ(got["merged"], true);
  for (const auto& point : got["points"]) {
    if (point["address"] == "1/0/3") {
      EXPECT_EQ(point["point"], "roof.sensor.temperature-north");
    }
  }
  EXPECT_THAT(got["groups"].get<std::string>(), HasSubstr("name: Outside"));
}

TEST(KnxImporter, AProtectedProjectWantsItsPassword) {
  auto house = support::small_house(21);
  house.password = "secret";
  auto request = upload("house.knxproj", house.file());
  EXPECT_THAT(error(request), HasSubstr("password"));
  request.password = "wrong";
  EXPECT_THAT(error(request), HasSubstr("password"));
  request.password = "secret";
  const auto got = preview(request);
  EXPECT_GT(got["points"].size(), 3U) << got;
  EXPECT_THAT(got.dump(), testing::Not(HasSubstr("secret\"")));
  house.password.clear();
  EXPECT_EQ(preview(upload("upload", house.file()))["points"], got["points"]) << "recognised by its content";
}

/// A small archive that claims to be a gigabyte, and others that are none of ours.
TEST(KnxImporter, FilesOfAnotherKindAreRefusedWithTheReason) {
  const auto bomb = support::zip_of({{"knx_master.xml", std::string(40 << 20, ' ')}});
  ASSERT_LT(bomb.size(), 200'000U);
  EXPECT_THAT(error(upload("bomb.knxproj", bomb)), HasSubstr("times"));
  EXPECT_THAT(error(upload("cut.knxproj", support::small_house(20).file().substr(0, 400))), HasSubstr("cut.knxproj"));
  EXPECT_THAT(error(upload("accounts.csv", "Date;Amount;Text\n2026-01-01;12.50;Bread\n")), HasSubstr("accounts.csv"));
  EXPECT_THAT(error(upload("photo.csv", std::string("\x89PNG\r\n\x1a\n\0\0\0", 11))), HasSubstr("photo.csv"));
  EXPECT_THAT(error(upload("page.xml", "<!DOCTYPE html><html/>")), HasSubstr("page.xml"));
  EXPECT_THAT(error(upload("groups.yaml", "island: {id: 1}\n")), HasSubstr("groups.yaml:1:1"));
  EXPECT_THAT(error(upload("groups.yaml", "groups: {}\n")), HasSubstr("no group address"));
}

}  // namespace
}  // namespace rubicon::daemon
