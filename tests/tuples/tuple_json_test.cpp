#include "tuples/tuple_json.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>

namespace rubicon::tuples {
namespace {

tuples::Event event_with(std::string_view value) {
  tuples::Event event;
  event.tuple.owner = OwnerId(6541);
  event.tuple.key = "proxy.dummy.a.sensor.light-1.value";
  event.tuple.value = value;
  event.tuple.media_type = "text/plain";
  event.tuple.sequence = 7;
  event.tuple.write_time = WallTime(std::chrono::microseconds(1'795'235'613'698'703));
  return event;
}

TEST(EventJson, HasTheFieldsOfAWatchLineInOrder) {
  ::setenv("TZ", "CET-1", 1);
  EXPECT_EQ(event_line(event_with("686.6")),
            R"({"owner":6541,"key":"proxy.dummy.a.sensor.light-1.value","value":"686.6","mimetype":"text/plain",)"
            R"("seq":7,"write":1795235613.698703,"user":0.0,)"
            R"("time":"2026-11-21T05:33:33.698703+01:00","event":"set"})");
  ::unsetenv("TZ");
}

TEST(EventJson, TellsDeletedAndExpiredApart) {
  auto event = event_with("1");
  event.kind = tuples::EventKind::kDeleted;
  EXPECT_EQ(nlohmann::json::parse(event_line(event))["event"], "deleted");
  event.kind = tuples::EventKind::kExpired;
  EXPECT_EQ(nlohmann::json::parse(event_line(event))["event"], "expired");
}

TEST(EventJson, StaysOneLineWhateverTheValue) {
  const auto line = event_line(event_with("a\nb\"\\\x01 \xc3\xbc"));
  EXPECT_EQ(line.find('\n'), line.npos);
  EXPECT_EQ(nlohmann::json::parse(line)["value"], "a\nb\"\\\x01 \xc3\xbc");
}

TEST(EventJson, ShowsBytesThatAreNoTextAsHex) {
  const auto line = nlohmann::json::parse(event_line(event_with(std::string_view("\xff\x00\x01", 3))));
  EXPECT_EQ(line["value_hex"], "ff0001");
  EXPECT_FALSE(line.contains("value"));
}

TEST(EventJson, KnowsUtf8FromOtherBytes) {
  for (const std::string_view good : {"", "abc", "\xc3\xbc", "\xe2\x82\xac", "\xf0\x9f\x98\x80", "\xed\x9f\xbf"}) {
    EXPECT_TRUE(base::is_utf8(good)) << good;
  }
  for (const std::string_view bad : {"\x80", "\xc3", "\xc0\x80", "\xe0\x80\x80", "\xed\xa0\x80", "\xf5\x80\x80\x80",
                                     "\xf4\x90\x80\x80", "\xe2\x82", "\xe2\x28\xa1"}) {
    EXPECT_FALSE(base::is_utf8(bad)) << bad;
  }
}

}  // namespace
}  // namespace rubicon::tuples
