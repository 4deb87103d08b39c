#include "web/api/site.h"
#include "web/importer.h"

namespace rubicon::web::api {
namespace {

using testing::HasSubstr;

struct FakeImporter final : Importer {
  void preview(ImportRequest request, std::function<void(Result<std::string>)> done) override {
    requests.push_back(std::move(request));
    late = std::move(done);
    if (answers) late(*answers);
  }
  std::vector<ImportRequest> requests;
  std::optional<Result<std::string>> answers = Result<std::string>(R"({"points":[]})");
  std::function<void(Result<std::string>)> late;
};

class ImportOfTheApi : public Sites {
 protected:
  ImportOfTheApi() { options.importer = &importer; }
  FakeImporter importer;
};

TEST_F(ImportOfTheApi, AFileGoesToTheImporterWithItsPasswordApart) {
  const std::string file("PK\x03\x04\0\xff", 6);
  const auto answer = ask("POST", "/api/v1/import?name=hall.knxproj&network=knx-hall&no-guess", file,
                          {{"content-type", "application/octet-stream"}, {"rubicon-password", "gr%C3%BCn%20%25"}});
  EXPECT_EQ(answer.status, 200U) << answer.body;
  EXPECT_EQ(answer.body, R"({"points":[]})");
  ASSERT_EQ(importer.requests.size(), 1U);
  const auto& got = importer.requests.front();
  EXPECT_EQ(got.content, file);
  EXPECT_EQ(got.name, "hall.knxproj");
  EXPECT_EQ(got.network, "knx-hall");
  EXPECT_EQ(got.password, "gr\xc3\xbcn %");
  EXPECT_EQ(got.choices, "");
  EXPECT_FALSE(got.guess);
}

TEST_F(ImportOfTheApi, ChoicesComeWithTheGroupFileOfBefore) {
  const Json body{{"groups", "groups: {}\n"}, {"choices", {{"1/0/1", {{"dpt", "9.001"}}}}}};
  EXPECT_EQ(ask("POST", "/api/v1/import", body.dump(), {{"content-type", "application/json"}}).status, 200U);
  EXPECT_EQ(importer.requests.front().content, "groups: {}\n");
  EXPECT_EQ(importer.requests.front().name, "groups.yaml");
  EXPECT_EQ(Json::parse(importer.requests.front().choices), body["choices"]);
  for (const auto* wrong : {"{", "{}", R"({"groups":7,"choices":{}})", R"({"groups":"a","choices":[]})"})
    EXPECT_EQ(ask("POST", "/api/v1/import", wrong, {{"content-type", "application/json"}}).status, 400U) << wrong;
  EXPECT_EQ(importer.requests.size(), 1U);
}

TEST_F(ImportOfTheApi, WhatTheImporterRefusesIsTheAnswer) {
  importer.answers = fail(ErrorCode::kInvalid, "flat.csv is no list");
  const auto answer = ask("POST", "/api/v1/import", "a;b");
  EXPECT_EQ(answer.status, 400U);
  EXPECT_THAT(answer.body, HasSubstr("flat.csv is no list"));
  importer.answers = fail(ErrorCode::kBusy, "another file is being read");
  EXPECT_EQ(ask("POST", "/api/v1/import", "a;b").status, 429U);
}

TEST_F(ImportOfTheApi, OnlyTheRoleAdminUploadsAndOnlyAdminsMaySendLongFiles) {
  EXPECT_EQ(ask("POST", "/api/v1/import", "a;b", {}, Role::kCommand).status, 403U);
  EXPECT_TRUE(importer.requests.empty());
  const auto takes = [&](const std::string& method, const std::string& target, Role role) {
    return site().takes_file(request_of(method, target, "", {}, role));
  };
  EXPECT_TRUE(takes("POST", "/api/v1/import?name=a", Role::kAdmin));
  EXPECT_FALSE(takes("POST", "/api/v1/import", Role::kCommand));
  EXPECT_FALSE(takes("GET", "/api/v1/import", Role::kAdmin));
  EXPECT_FALSE(takes("POST", "/api/v1/inbox", Role::kAdmin));
}

TEST_F(ImportOfTheApi, WrongRequestsSayWhatWasExpected) {
  EXPECT_THAT(ask("POST", "/api/v1/import", "").body, HasSubstr("the file is empty"));
  EXPECT_THAT(ask("POST", "/api/v1/import?nmae=a", "a").body, HasSubstr("nmae"));
  EXPECT_EQ(ask("POST", "/api/v1/import", "a", {{"rubicon-password", "%zz"}}).status, 400U);
  EXPECT_TRUE(importer.requests.empty());
}

TEST_F(ImportOfTheApi, AClientThatLeftGetsNothing) {
  importer.answers.reset();
  bool answered = false;
  auto exchange = site().handle(request_of("POST", "/api/v1/import", "a;b"), [&](const Response&) { answered = true; });
  exchange.reset();
  importer.late(Result<std::string>("{}"));
  EXPECT_FALSE(answered);
}

TEST_F(Sites, AServerWithoutAnIslandReadsNoProjects) {
  const auto answer = ask("POST", "/api/v1/import", "a;b");
  EXPECT_EQ(answer.status, 501U);
  EXPECT_THAT(answer.body, HasSubstr("only the page of an island"));
}

/// With `trust_lan` and no tokens whoever reaches the port is the caller.
TEST_F(Sites, WithoutTokensTheFileIsChangedFromItsOwnHostOnly) {
  start_island(1);
  scheduler.run_for(1s);
  const auto set = [&](const std::string& value, const std::string& peer) {
    auto request = request_of("PUT", "/api/v1/tuples/1/proxy.settings.command", value);
    request.caller.peer = peer;
    std::optional<Response> response;
    const auto exchange = site().handle(request, [&](Response answer) { response = std::move(answer); });
    for (int i = 0; i < 1200 && !response; ++i) scheduler.run_for(50ms);
    return response ? response->body : std::string();
  };
  for (const auto* change : {"undo", R"({"do":"undo"})"}) {
    EXPECT_THAT(set(change, "192.168.1.7"), HasSubstr("from its own host only")) << change;
    EXPECT_THAT(set(change, "127.0.0.1"), HasSubstr("this program cannot change its configuration")) << change;
    EXPECT_THAT(set(change, "::1"), HasSubstr("this program cannot change its configuration")) << change;
  }
  EXPECT_THAT(set("try", "192.168.1.7"), HasSubstr("this program cannot read its configuration again"));
}

}  // namespace
}  // namespace rubicon::web::api
