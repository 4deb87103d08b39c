#include "model/alerts.h"

#include <gtest/gtest.h>

namespace rubicon::model {
namespace {

Alert silent() {
  return {"device-silent",
          "proxy.wsn-1.7",
          Severity::kWarning,
          WallTime(std::chrono::milliseconds(1500)),
          "Kitchen is not reachable",
          "check its battery"};
}

TEST(Alerts, JsonBringsBackEveryMember) {
  AlertList list;
  list.add(silent);
  list.add([] {
    auto line = silent();
    line.severity = Severity::kProblem;
    return line;
  });
  list.more = 3;
  EXPECT_EQ(alerts_from_json(alerts_to_json(list)), list);
  EXPECT_EQ(alerts_to_json({}), R"({"alerts":[],"more":0})");
}

TEST(Alerts, AListHasABoundAndCountsTheRest) {
  AlertList list;
  int made = 0;
  for (int i = 0; i < 1000; ++i)
    list.add([&made] {
      ++made;
      auto one = silent();
      one.what = std::string(100'000, 'x');
      return one;
    });
  EXPECT_EQ(list.all.size(), AlertList::kMaxAlerts);
  EXPECT_EQ(made, AlertList::kMaxAlerts);
  EXPECT_EQ(list.more, 800U);
  EXPECT_LT(alerts_to_json(list).size(), 200'000U);
}

TEST(Alerts, WhatIsNoListReadsAsEmpty) {
  for (const auto* text : {"", "no json", "[]", "{}", R"({"alerts":3})", R"({"alerts":[3,"x",null]})"})
    EXPECT_EQ(alerts_from_json(text), AlertList()) << text;
  const auto odd = alerts_from_json(R"({"alerts":[{"kind":3,"severity":"unheard","since":"now"}],"more":-1})");
  ASSERT_EQ(odd.all.size(), 1U);
  EXPECT_EQ(odd.all[0], Alert());
}

}  // namespace
}  // namespace rubicon::model
