#include "networks/wsn/packet_monitor.h"

#include <nlohmann/json.hpp>

#include "networks/wsn/wsn_fixture.h"

namespace rubicon::networks::wsn {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

class WatchedPackets : public MoteNetwork {
 protected:
  /// Sends a request of component 70001; the reply.
  json ask(const json& request) {
    host.delivered.clear();
    const auto text = request.dump();
    EXPECT_TRUE(send("", model::Opaque{std::string(kRequestTag), {text.begin(), text.end()}}, kViewer));
    const auto replies = messages(kReplyTag);
    return replies.size() == 1 ? replies[0] : json(replies.size());
  }
  std::vector<json> messages(std::string_view tag) const {
    std::vector<json> found;
    for (const auto& message : host.delivered) {
      const auto* opaque = std::get_if<model::Opaque>(&message.body);
      if (!opaque || opaque->type != tag) continue;
      EXPECT_EQ(message.destination, kViewer);
      found.push_back(json::parse(opaque->bytes.begin(), opaque->bytes.end()));
    }
    return found;
  }
  static inline const Address kViewer{OwnerId(70001), "", ""};
};

TEST_F(WatchedPackets, AreShownInBothDirectionsUntilTheLeaseEnds) {
  start(2);
  const auto reply = ask({{"do", "monitor"}, {"id", "m"}, {"seconds", 60}});
  EXPECT_EQ(reply["ok"], true);
  EXPECT_EQ(reply["id"], "m");
  EXPECT_EQ(reply["line"], true);
  ASSERT_TRUE(demand("2", {"light"}));
  run(5s);
  std::set<std::string> kinds;
  for (const auto& packet : messages(kPacketTag)) {
    kinds.insert(packet["direction"].get<std::string>() + " " + packet["kind"].get<std::string>());
    EXPECT_GT(packet["time"].get<double>(), 0);
    EXPECT_FALSE(packet["hex"].get<std::string>().empty());
    if (packet["kind"] == "readings") {
      EXPECT_EQ(packet["mote"], 2);
      EXPECT_THAT(packet["text"].get<std::string>(), HasSubstr("2 -> "));
      EXPECT_THAT(packet["text"].get<std::string>(), HasSubstr("light "));
    }
  }
  EXPECT_THAT(kinds, testing::IsSupersetOf({"out sampling", "in acknowledge", "in readings"}));
  run(60s);
  host.delivered.clear();
  run(5s);
  EXPECT_THAT(messages(kPacketTag), IsEmpty());
  EXPECT_THAT(readings("2", "light"), Not(IsEmpty())) << "the network itself goes on";
}

TEST_F(WatchedPackets, ALeaseIsRenewedAndEnded) {
  start(1);
  ask({{"do", "monitor"}, {"id", "m"}, {"seconds", 10}});
  ASSERT_TRUE(demand("2", {"light"}));
  run(8s);
  ask({{"do", "monitor"}, {"id", "m"}, {"seconds", 10}});
  host.delivered.clear();
  run(8s);
  const auto count = messages(kPacketTag).size();
  EXPECT_GT(count, 5U);
  EXPECT_LE(count, 20U) << "once each, not twice";
  EXPECT_EQ(ask({{"do", "monitor"}, {"id", "m"}, {"seconds", 0}})["ok"], true);
  host.delivered.clear();
  run(5s);
  EXPECT_THAT(messages(kPacketTag), IsEmpty());
}

TEST_F(WatchedPackets, AreNotShownToWhoAddressesOneMote) {
  start(2);
  host.delivered.clear();
  const std::string text = R"({"do": "monitor", "id": "m"})";
  const auto answer = send("2", model::Opaque{std::string(kRequestTag), {text.begin(), text.end()}}, kViewer);
  ASSERT_FALSE(answer);
  EXPECT_EQ(answer.error().code, ErrorCode::kRefused);
  ASSERT_TRUE(demand("2", {"light"}));
  run(5s);
  EXPECT_THAT(messages(kPacketTag), IsEmpty());
}

TEST_F(WatchedPackets, RequestsAreAnsweredOnceAndBounded) {
  start(1);
  EXPECT_THAT(ask({{"do", "dance"}, {"id", "x"}})["why"].get<std::string>(), HasSubstr("expected monitor"));
  EXPECT_THAT(ask(json::object())["why"].get<std::string>(), HasSubstr("expected monitor"));
  for (std::size_t i = 0; i < network::Monitors::kMaxCount; ++i)
    EXPECT_EQ(ask({{"do", "monitor"}, {"id", std::to_string(i)}})["ok"], true);
  EXPECT_EQ(ask({{"do", "monitor"}, {"id", "one more"}})["why"], "too many monitors are open");
  EXPECT_EQ(ask({{"do", "monitor"}, {"id", "0"}})["ok"], true) << "renewed";
  const auto broken = send("", model::Opaque{std::string(kRequestTag), {'{'}}, kViewer);
  ASSERT_FALSE(broken);
  EXPECT_EQ(broken.error().code, ErrorCode::kInvalid);
}

}  // namespace
}  // namespace rubicon::networks::wsn
