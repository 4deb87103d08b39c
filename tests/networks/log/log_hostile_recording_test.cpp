#include <fmt/format.h>

#include "networks/log/log_recordings.h"
#include "networks/log/tuple_recording.h"
#include "recording/file_format.h"

namespace rubicon::networks::log {
namespace {

using testing::ElementsAre;
using testing::Gt;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Le;

class HostileRecording : public LogRecording {
 protected:
  /// Readings that each turn of the loop delivers.
  std::vector<std::size_t> readings_by_turn(const std::string& file) {
    std::vector<std::size_t> turns;
    std::size_t before = 0;
    std::function<void()> watch = [&] {
      const auto now = listener_.readings().size();
      if (now != before) turns.push_back(now - before);
      before = now;
      if (!listener_.of<model::State>().empty() && listener_.last_state().line == model::LineState::kEnded) return;
      listener_.time.post(watch);
    };
    listener_.time.post(watch);
    play(file, {{"speed", scalar("max")}}, 10s);
    return turns;
  }
  /// All that a recording says in one go, as long as it has something; how often it let others go first.
  std::size_t drain(TupleRecording& recording) {
    std::size_t pauses = 0;
    for (;;) {
      while (const auto step = recording.next()) most_messages_ = std::max(most_messages_, step->messages.size());
      if (!recording.has_more()) return pauses;
      ++pauses;
    }
  }
  TupleRecording recording(const std::string& network = "wsn-1") {
    return {types_, network, counters_, [this](std::uint64_t at, std::string_view what) {
              complaints_.push_back(fmt::format("{}: {}", at, what));
            }};
  }

  ReplayCounters counters_;
  std::vector<std::string> complaints_;
  std::size_t most_messages_ = 0;
};

TEST_F(HostileRecording, AMomentWithManyReadingsIsToldInSharesAndNothingIsLost) {
  constexpr int kMany = 15'000;
  Writer writer;
  join_mote(writer);
  writer.same_turn = true;
  writer.user = writer.now;
  for (int i = 0; i < kMany; ++i) writer.set("proxy.wsn-1.7.sensor.light-1.value", std::to_string(i));
  const auto turns = readings_by_turn(writer.file());
  EXPECT_THAT(turns, testing::Each(Le(1250u)));
  const auto all = delivered();
  ASSERT_EQ(all.size(), static_cast<std::size_t>(kMany));
  for (int i = 0; i < kMany; ++i) ASSERT_EQ(all[static_cast<std::size_t>(i)], std::to_string(i));
}

TEST_F(HostileRecording, ASnapshotOfManyDevicesIsToldInSharesAndNothingIsLost) {
  constexpr int kMany = 6000;
  Writer writer;
  writer.mark("start");
  writer.same_turn = true;
  writer.user = writer.now;
  for (int i = 0; i < kMany; ++i) {
    for (const auto* sensor : {"light-1", "light-2"})
      writer.present(fmt::format("proxy.wsn-1.{}.sensor.{}.value", i, sensor), "5");
  }
  writer.mark("complete");
  const auto turns = readings_by_turn(writer.file());
  EXPECT_THAT(turns, testing::Each(Le(1250u)));
  EXPECT_EQ(joins().size(), static_cast<std::size_t>(kMany));
  EXPECT_EQ(delivered().size(), 2u * kMany);
}

TEST_F(HostileRecording, AllDevicesLeaveInSharesWhenASnapshotDoesNotNameThem) {
  constexpr int kMany = 6000;
  Writer writer;
  writer.same_turn = true;
  for (int i = 0; i < kMany; ++i) writer.set(fmt::format("proxy.wsn-1.{}.sensor.light-1.value", i), "5");
  writer.same_turn = false;
  writer.mark("snapshot");
  writer.mark("complete");
  auto played = recording();
  played.begin("x", {});
  const auto file = writer.file();
  played.feed(base::as_bytes(file));
  played.end();
  EXPECT_THAT(drain(played), Gt(2u));
  EXPECT_THAT(most_messages_, Le(250u));
  EXPECT_THAT(played.devices(), IsEmpty());
}

TEST_F(HostileRecording, RecordsThatMatchNothingLetOthersGoFirst) {
  Writer writer;
  for (int i = 0; i < 200'000; ++i) writer.set("robot.position", "1");
  auto played = recording();
  played.begin("x", {});
  const auto file = writer.file();
  played.feed(base::as_bytes(file));
  played.end();
  EXPECT_THAT(drain(played), Gt(19u));
  EXPECT_EQ(counters_.records, 200'000u);
}

TEST_F(HostileRecording, MoreDevicesThanAnIslandTakesAreNotRemembered) {
  Writer writer;
  for (std::size_t i = 0; i < RecordedKeys::kMaxDevices + 500; ++i)
    writer.set(fmt::format("proxy.wsn-1.{}.sensor.light-1.value", i), "5");
  auto played = recording();
  played.begin("x", {});
  const auto file = writer.file();
  played.feed(base::as_bytes(file));
  played.end();
  drain(played);
  EXPECT_EQ(played.devices().size(), RecordedKeys::kMaxDevices);
  EXPECT_THAT(complaints_, ElementsAre(HasSubstr("more devices than are played, expected at most 20000")));
}

TEST_F(HostileRecording, MorePointsThanADeviceHasAndUnknownTypesAreNotRemembered) {
  Writer writer;
  writer.same_turn = true;
  for (std::size_t i = 0; i < RecordedKeys::kMaxPoints + 5; ++i)
    writer.set(fmt::format("proxy.wsn-1.7.sensor.light-{}.value", i), "5");
  for (int i = 0; i < 2000; ++i) writer.set(fmt::format("proxy.wsn-1.8.sensor.mood{}-1.value", i), "5");
  auto played = recording();
  played.begin("x", {});
  const auto file = writer.file();
  played.feed(base::as_bytes(file));
  played.end();
  drain(played);
  EXPECT_THAT(complaints_, ElementsAre(HasSubstr("more points of a device than are played, expected at most 2048"),
                                       HasSubstr("more unknown types than are played, expected at most 500")));
}

TEST_F(HostileRecording, DescriptionsAreRememberedUpToABound) {
  Writer writer;
  std::string long_name(200 << 10, 'x');
  for (int i = 0; i < 330; ++i)
    writer.describe(fmt::format("proxy.wsn-1.{}.description", i), "{\"name\":\"" + long_name + "\"}");
  writer.describe("proxy.wsn-1.7.description", "{\"name\":\"" + long_name + long_name + "\"}");
  auto played = recording();
  played.begin("x", {});
  const auto file = writer.file();
  played.feed(base::as_bytes(file));
  played.end();
  EXPECT_THAT(drain(played), Gt(100u)) << "to parse them takes its time";
  EXPECT_THAT(complaints_, ElementsAre(HasSubstr("more bytes of descriptions than are played"),
                                       HasSubstr("expected a JSON object of at most 262144 bytes")));
}

TEST_F(HostileRecording, TimesAtTheEndsOfTheirRangeDoNoHarm) {
  for (const bool snapshot : {false, true}) {
    Writer writer;
    if (snapshot) writer.mark("snapshot");
    writer.same_turn = true;
    for (const auto time : {WallTime::min(), WallTime::max(), WallTime{}, WallTime::max(), WallTime::min()}) {
      writer.now = time;
      writer.user = WallTime::max();
      writer.set("proxy.wsn-1.7.sensor.light-1.value", "1");
      writer.user = WallTime::min();
      writer.set("proxy.wsn-1.7.sensor.light-1.status", R"({"quality":"device-offline","since":0,"heard":9e11})");
      writer.set("proxy.wsn-1.7.sensor.light-1.value", "2");
    }
    for (const auto* speed : {"1", "0.001", "1000000", "max"}) {
      listener_.heard.clear();
      play(writer.file(), {{"speed", scalar(speed)}}, 1min);
      EXPECT_FALSE(joins().empty());
    }
  }
}

TEST(HostileBlocks, ThatAreCheckedForNothingLetOthersGoFirst) {
  // Consecutive heads, each of a block of two megabytes with a wrong check sum.
  Bytes file = recording::encode_head({IslandId(1), "proxy", {}, ""});
  recording::BlockHead head;
  head.packed = 1 << 20;
  head.raw = 1 << 20;
  head.records = 1;
  Bytes one(recording::kBlockHead);
  recording::encode_block_head(head, one.data());
  for (int i = 0; i < 100; ++i) file.insert(file.end(), one.begin(), one.end());
  file.resize(file.size() + (2 << 20), 0);
  recording::RecordingReader reader(4 << 20);
  reader.feed(file);
  std::size_t pauses = 0;
  for (;;) {
    const auto item = reader.next();
    if (!item && !reader.busy()) break;
    if (!item) ++pauses;
  }
  EXPECT_THAT(pauses, Gt(20u));
}

/// What an island remembers from before its start is published as stored, right after the value.
class StoredValues : public LogRecording {
 protected:
  void status(Writer& to, std::string_view quality, std::string_view heard) {
    to.describe(kStatus,
                fmt::format(R"({{"quality":"{}","since":1700000000.0,"heard":{},"changed":null}})", quality, heard));
  }
  const std::string kStatus = "proxy.wsn-1.7.sensor.light-1.status";
  const std::string kValue = "proxy.wsn-1.7.sensor.light-1.value";
  Writer writer;
};

TEST_F(StoredValues, AreNoReadingsAfterARestart) {
  for (const auto* shown : {"stored", "network-down", "device-offline", "unknown"}) {
    listener_.heard.clear();
    Writer one;
    one.mark("start");
    one.mark("complete");
    one.now += 1s;
    one.same_turn = true;
    one.set(kValue, "");
    status(one, "unknown", "null");
    one.describe("proxy.wsn-1.7.sensor.light-1.description", kLight);
    one.describe("proxy.wsn-1.7.description", kMote);
    one.set(kValue, "686.6");
    status(one, shown, "1699990000.000000");
    one.same_turn = false;
    play(one.file());
    ASSERT_EQ(joins().size(), 1u) << shown;
    EXPECT_EQ(joins()[0].capabilities.at(0).initial, Value{}) << shown;
    EXPECT_THAT(delivered(), IsEmpty()) << shown;
  }
}

TEST_F(StoredValues, AreFollowedByWhatIsHeard) {
  join_mote(writer);
  writer.same_turn = true;
  status(writer, "unknown", "null");
  writer.set(kValue, "1");
  status(writer, "stored", "1699990000.000000");
  writer.same_turn = false;
  writer.set(kValue, "2");
  writer.same_turn = true;
  status(writer, "good", "1700000003.000000");
  writer.same_turn = false;
  writer.set(kValue, "3");
  play(writer.file());
  EXPECT_THAT(delivered(), ElementsAre("2", "3"));
  const auto updates = listener_.of<model::Updates>();
  EXPECT_EQ(updates[1].first - updates[0].first, 1s) << "each at its own time";
}

TEST_F(StoredValues, AReadingOfADeviceThatWasOfflineCountsBeforeItsStatusFollows) {
  join_mote(writer);
  status(writer, "device-offline", "1699990000.000000");
  writer.set(kValue, "2");
  writer.set(kValue, "3");
  status(writer, "good", "1700000004.000000");
  play(writer.file());
  EXPECT_THAT(delivered(), ElementsAre("2", "3"));
}

TEST_F(StoredValues, OfASnapshotAreToldApartWhateverComesFirst) {
  for (const bool status_first : {true, false}) {
    for (const bool stored : {true, false}) {
      listener_.heard.clear();
      Writer one;
      one.mark("snapshot");
      one.same_turn = true;
      one.user = one.now;
      // The value was written when the status says it was heard, or later.
      const auto heard = std::to_string(one.now.time_since_epoch().count() / 1'000'000 - (stored ? 1000 : 0));
      const auto json = "{\"quality\":\"device-offline\",\"since\":1.0,\"heard\":" + heard + "}";
      if (status_first) one.present(kStatus, json);
      one.present(kValue, "5");
      if (!status_first) one.present(kStatus, json);
      one.present("proxy.wsn-1.7.sensor.light-1.description", kLight);
      one.present("proxy.wsn-1.7.description", kMote);
      one.mark("complete");
      play(one.file());
      EXPECT_EQ(delivered().size(), stored ? 0u : 1u) << status_first;
      EXPECT_EQ(joins().size(), 1u);
    }
  }
}

}  // namespace
}  // namespace rubicon::networks::log
