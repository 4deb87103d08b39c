#include <gtest/gtest.h>

#include <optional>

#include "web/api/site.h"

namespace rubicon::web::api {
namespace {

/// Of what the owner did not apply (docs/api.md): `70000` gets each request after its time, the answers of `70001` are
/// lost.
class Outcomes : public Sites {
 protected:
  Outcomes() {
    site();
    scheduler.run_for(1s);
  }
  void lose_answers() { ecology.cut(OwnerId(kSite), OwnerId(70001)); }

 private:
  static tuples::SetDecision too_late(const tuples::RemoteSet&) {
    return {tuples::Verdict::kExpired, false, ErrorCode::kExpired, "it came too late", {}};
  }
  static tuples::SetDecision accepted(const tuples::RemoteSet&) { return tuples::SetDecision::applied(); }

  tuples::Handle late_ = component(70000).add_policy({std::nullopt, "**"}, too_late);
  tuples::Handle lost_ =
      component(70001).add_policy({std::nullopt, "**"}, accepted, tuples::PolicyScope::kSetsAndAppends);
};

TEST_F(Outcomes, APutThatWasNotExecutedIsToldApartFromOneOfWhichNobodyKnows) {
  const auto expired = ask("PUT", "/api/v1/tuples/70000/note", "x");
  EXPECT_EQ(expired.status, 504U);
  EXPECT_EQ(Json::parse(expired.body)["state"], "expired");
  std::optional<Response> response;
  const auto exchange =
      site().handle(request_of("PUT", "/api/v1/tuples/70001/note", "x"), [&](Response r) { response = std::move(r); });
  lose_answers();
  scheduler.run_for(30s);
  ASSERT_TRUE(response);
  EXPECT_EQ(response->status, 504U);
  EXPECT_EQ(Json::parse(response->body)["state"], "timed-out");
  EXPECT_EQ(Json::parse(response->body)["error"]["code"], "expired");
}

TEST_F(Outcomes, AVerdictTellsWhatWasNotExecutedFromWhatNobodyKnows) {
  auto& page = Sites::page();
  scheduler.run_for(1s);
  const auto expired = page.ask({{"do", "set"}, {"key", "70000:note"}, {"value", "x"}});
  const auto command = page.ask({{"do", "set"}, {"key", "70000:lamp.command"}, {"value", "x"}});
  const auto timed_out = page.ask({{"do", "append"}, {"key", "70001:note"}, {"value", "x"}});
  lose_answers();
  scheduler.run_for(30s);
  for (const auto id : {expired, command}) EXPECT_EQ(page.answer(id)["verdict"], "expired") << page.answer(id);
  EXPECT_EQ(page.answer(timed_out)["verdict"], "timed-out") << page.answer(timed_out);
  for (const auto id : {expired, command, timed_out}) {
    EXPECT_EQ(page.answer(id)["ok"], false);
    EXPECT_EQ(page.answer(id)["error"]["code"], "expired");
    EXPECT_TRUE(page.answer(id)["request"].is_number());
  }
}

}  // namespace
}  // namespace rubicon::web::api
