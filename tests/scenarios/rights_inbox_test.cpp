#include <gmock/gmock.h>

#include "scenarios/ecology.h"
#include "support/rights.h"

namespace rubicon::scenarios {
namespace {

using support::Right;
using support::rule;
using testing::HasSubstr;
using tuples::Verdict;

constexpr std::uint32_t kPanelId = 70001;

/// A panel that may decide about devices of the inbox, but not about one of them.
class RightsOfTheInbox : public Ecology {
 protected:
  void start(const std::string& discovery, std::vector<std::string> keys, std::vector<std::string> except) {
    ecology.certify(OwnerId(kPanelId), support::tool_member("panel", kPanelId));
    ecology.judge(OwnerId(1),
                  support::judge_of({rule("panel", {Right::kApprove}, std::move(keys), std::move(except))}, nullptr));
    start_island(1, "devices: {9: {id: kitchen}}}\ndiscovery: {new-devices: " + discovery);
    for (const auto* device : {"7", "8", "9"}) devices_of(1).say(device, lamp());
    scheduler.run_ready();
  }
  tuples::Reply decide(const std::string& value, const std::string& key = "proxy.inbox") {
    tuples::Reply answer;
    component(kPanelId).set_remote(OwnerId(1), key, value, 1s, [&](const tuples::Reply& reply) { answer = reply; });
    scheduler.run_for(1s);
    return answer;
  }
  bool is_listed(const std::string& device) {
    return value(islands[1]->space(), 1, "proxy.scripted-1." + device + ".status") != "(none)";
  }
};

TEST_F(RightsOfTheInbox, AnExceptionBelowTheInboxHoldsForDecisionsAboutMany) {
  start("ask", {"proxy.inbox.**"}, {"proxy.inbox.scripted-1.8"});
  const auto one = decide("approve scripted-1.8");
  EXPECT_EQ(one.verdict, Verdict::kRefused);
  EXPECT_THAT(one.text, HasSubstr("panel may not approve proxy.inbox.scripted-1.8: rule 1 denies it"));
  const auto all = decide("approve *");
  EXPECT_EQ(all.verdict, Verdict::kApplied);
  EXPECT_THAT(all.text, HasSubstr("left out: panel may not approve proxy.inbox.scripted-1.8"));
  EXPECT_TRUE(is_listed("7"));
  EXPECT_FALSE(is_listed("8"));
}

TEST_F(RightsOfTheInbox, WhoMaySetTheInboxAloneDecidesAboutNoDevice) {
  start("ask", {"proxy.inbox"}, {});
  EXPECT_THAT(decide("approve *").text, HasSubstr("no rule allows it"));
  EXPECT_FALSE(is_listed("7"));
}

TEST_F(RightsOfTheInbox, AListedDeviceIsNotIgnoredAroundItsException) {
  start("auto", {"proxy.inbox.**"}, {"proxy.inbox.scripted-1.8", "proxy.inbox.scripted-1.kitchen"});
  for (const auto* name : {"8", "9", "kitchen"}) {
    EXPECT_EQ(decide(std::string("ignore scripted-1.") + name).verdict, Verdict::kRefused) << name;
  }
  EXPECT_EQ(decide("ignore scripted-1.7").verdict, Verdict::kApplied);
  EXPECT_FALSE(is_listed("7"));
  EXPECT_TRUE(is_listed("8"));
  EXPECT_TRUE(is_listed("kitchen"));
}

}  // namespace
}  // namespace rubicon::scenarios
