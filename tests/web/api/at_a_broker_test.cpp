#include "tuples/mqtt/site.h"
#include "web/api/site.h"

namespace rubicon::web::api {
namespace {

using testing::IsEmpty;

/// The page of an island that meets others at a broker, once it deals with them.
class AtABroker : public testing::Test {
 protected:
  /// Islands that ran for an hour.
  AtABroker() {
    EXPECT_TRUE(hall.space->set("lamp", "on"));
    time.run_for(1h);
  }
  Response ask(const std::string& target) {
    const auto begun = time.now();
    std::optional<Response> response;
    const auto exchange =
        api.handle(Sites::request_of("GET", target), [&](Response answer) { response = std::move(answer); });
    for (int i = 0; i < 1000 && !response; ++i) time.run_for(10ms);
    EXPECT_TRUE(response) << target;
    took = time.now() - begun;
    return response.value_or(Response{0});
  }

  VirtualScheduler time;
  transport::MemoryNet net{time};
  transport::MqttBroker broker{net, tuples::mqtt::kBroker};
  tuples::mqtt::SpaceOptions options = tuples::mqtt::options_at({tuples::mqtt::kBroker});
  tuples::mqtt::Site hall{time, net, OwnerId(1), "10.0.0.2", options}, lab{time, net, OwnerId(2), "10.0.0.3", options};
  access::Access access{time, access::AccessRules{}};
  Api api{time, *lab.space, lab.log, access, {"lab"}};
  Duration took{};
};

TEST_F(AtABroker, AnIslandThatWasNotMetYetIsReadAtOnce) {
  EXPECT_THAT(lab.take(), IsEmpty());
  const auto list = Json::parse(ask("/api/v1/tuples?pattern=1:*").body);
  ASSERT_EQ(list["tuples"].size(), 1U) << list;
  EXPECT_EQ(list["tuples"][0]["value"], "on");
}

TEST_F(AtABroker, ATupleOfAnIslandThatWasNotMetYetIsFound) {
  EXPECT_EQ(ask("/api/v1/tuples/1/lamp").status, 200U);
  EXPECT_LT(took, 1s);
}

TEST_F(AtABroker, AListOfAllHasThoseThatWereNotMetYet) {
  const auto list = Json::parse(ask("/api/v1/tuples?pattern=*:lamp").body);
  EXPECT_EQ(list["tuples"].size(), 1U) << list;
}

TEST_F(AtABroker, AnIslandThatIsNotThereIsKnownToBeMissing) {
  EXPECT_EQ(ask("/api/v1/tuples/7/lamp").status, 404U);
  EXPECT_LT(took, 1s);
}

/// Nobody knows when it is back.
TEST_F(AtABroker, AListOfAllDoesNotWaitForABrokerThatIsAway) {
  broker.stop(true);
  time.run_for(1min);
  ask("/api/v1/tuples?pattern=*:lamp");
  EXPECT_LT(took, 1s);
}

}  // namespace
}  // namespace rubicon::web::api
