#include "web/api/fake_history.h"
#include "web/api/site.h"

namespace rubicon::web::api {
namespace {

using testing::HasSubstr;

/// A site that keeps a history.
struct Histories : Sites {
  Histories() { options.history = &history; }
  static WallTime at(int seconds) { return WallTime(std::chrono::seconds(seconds)); }

  FakeHistory history{scheduler};
};

history::Answer light() {
  history::SeriesAnswer series;
  series.name = {OwnerId(1), "proxy.a.b.sensor.light-1.value"};
  series.unit = "lx";
  series.before = history::NumberValue{Histories::at(90), 5};
  series.buckets = {{Histories::at(100), 2, 1, 1, 3, 2, 3}, {Histories::at(110), 1, 4, 4, 4, 4, 4}};
  series.gaps = {{Histories::at(120), Histories::at(130)}};
  history::Answer answer;
  answer.bucket = 10s;
  answer.series = {series};
  return answer;
}

TEST_F(Histories, ThePastComesInListsOfTheBuckets) {
  history.answer = light();
  const auto answer = get("/api/v1/history?key=1:proxy.a.b.sensor.light-1.value&from=100&to=200.5&buckets=10");
  EXPECT_EQ(answer, Json::parse(R"({"from":100,"to":200.5,"bucket":10,"series":[
      {"key":"1:proxy.a.b.sensor.light-1.value","kind":"number","unit":"lx","before":[90,5],"t":[100,110],
       "first":[1,4],"min":[1,4],"max":[3,4],"mean":[2,4],"last":[3,4],"n":[2,1],"gaps":[[120,130]]}]})"));
  ASSERT_EQ(history.questions.size(), 1U);
  EXPECT_EQ(history.questions[0].buckets, 10U);
  EXPECT_EQ(history.questions[0].from, at(100));
  EXPECT_THAT(history.callers, testing::ElementsAre("local@127.0.0.1"));
}

TEST_F(Histories, BucketsOfOneValueHaveTheValueOnly) {
  history.answer = light();
  history.answer->series[0].buckets.erase(history.answer->series[0].buckets.begin());
  const auto series = get("/api/v1/history?key=1:a")["series"][0];
  EXPECT_EQ(series["v"], Json::array({4}));
  EXPECT_FALSE(series.contains("min"));
}

TEST_F(Histories, WithoutTimesItIsTheLastHourAndTimesMayBeAgo) {
  const auto now = scheduler.wall_now();
  ask("GET", "/api/v1/history?key=1:a&key=2:b");
  scheduler.run_for(1s);
  ask("GET", "/api/v1/history?key=1:a&from=-2h&to=-1h");
  ASSERT_EQ(history.questions.size(), 2U);
  EXPECT_EQ(history.questions[0].series.size(), 2U);
  EXPECT_EQ(history.questions[0].from, now - 1h);
  EXPECT_EQ(history.questions[1].to - history.questions[1].from, 1h);
}

TEST_F(Histories, ATableHasALineForEachValue) {
  auto answer = light();
  history::SeriesAnswer texts;
  texts.name = {OwnerId(1), "note"};
  texts.kind = history::SeriesKind::kText;
  texts.texts = {{at(105), "say \"hi\",\nnow"}};
  answer.series.push_back(texts);
  history.answer = answer;
  const auto response = ask("GET", "/api/v1/history?key=1:a", "", {{"accept", "text/csv"}});
  EXPECT_EQ(response.content_type, "text/csv");
  EXPECT_EQ(response.body,
            "time,key,count,first,minimum,maximum,mean,last\n"
            "100,1:proxy.a.b.sensor.light-1.value,2,1,1,3,2,3\n"
            "110,1:proxy.a.b.sensor.light-1.value,1,4,4,4,4,4\n"
            "105,1:note,1,,,,,\"say \"\"hi\"\",\nnow\"\n");
}

TEST_F(Histories, SeriesComeInPages) {
  for (const auto* key : {"a", "b", "c"})
    history.known.push_back({{OwnerId(1), key}, history::SeriesKind::kWords, "", {"off", "on"}, at(5), at(6)});
  const auto page = get("/api/v1/history/series?pattern=1:*&limit=2");
  ASSERT_EQ(page["series"].size(), 2U);
  EXPECT_EQ(page["series"][0], Json::parse(R"({"key":"1:a","kind":"words","unit":"","words":["off","on"],
                                               "first":5,"last":6})"));
  EXPECT_EQ(page["next"], "/api/v1/history/series?pattern=1:*&limit=2&after=1:b");
  EXPECT_EQ(to_string(history.patterns[0]), "1:*");
  EXPECT_EQ(history.ranges[0].most, 3U);
  ask("GET", page["next"].get<std::string>());
  EXPECT_EQ(history.ranges[1].after, "1:b");
}

TEST_F(Histories, AnErrorOfTheHistoryIsAnswered) {
  history.answer = fail(ErrorCode::kBusy, "too many questions wait");
  const auto response = ask("GET", "/api/v1/history?key=1:a");
  EXPECT_EQ(response.status, 429U);
  EXPECT_THAT(response.body, HasSubstr("too many questions wait"));
}

TEST_F(Histories, MetricsShowWhetherAllIsWritten) {
  history.counted = {1000, 3, 2, 65'536, false};
  const auto response = ask("GET", "/metrics");
  for (const auto* line : {"rubicon_history_points_total 1000\n", "rubicon_history_dropped_points_total 3\n",
                           "rubicon_history_failures_total 2\n", "rubicon_history_bytes 65536\n",
                           "# TYPE rubicon_history_recording gauge\nrubicon_history_recording 0\n"})
    EXPECT_THAT(response.body, HasSubstr(line));
}

TEST_F(Histories, MoreThanFiveReadsInASecondAreBusy) {
  std::vector<unsigned> statuses;
  std::vector<std::unique_ptr<Exchange>> exchanges;
  for (int i = 0; i < 7; ++i)
    exchanges.push_back(site().handle(request_of("GET", "/api/v1/history?key=1:a"),
                                      [&](const Response& response) { statuses.push_back(response.status); }));
  EXPECT_THAT(statuses, testing::ElementsAre(429U, 429U));
  scheduler.run_for(1s);
  EXPECT_EQ(statuses.size(), 7U);
}

}  // namespace
}  // namespace rubicon::web::api
