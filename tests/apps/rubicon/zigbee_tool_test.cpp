#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <deque>

#include "apps/rubicon/output/output.h"
#include "apps/rubicon/zigbee/tool.h"

namespace rubicon::cli::zigbee {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// A line without an island: each wait ends as the test prepared it, those after them at once, as after a signal.
class PreparedLine final : public ToolLine {
 public:
  explicit PreparedLine(int output) : ToolLine({"request", "reply", "event"}), out_(output) {}

  void send(const json& request) override { sent.push_back(request); }
  bool run(const std::function<bool()>& done, Duration) override {
    EXPECT_FALSE(interrupted_) << "the wait would end at once";
    ++waits;
    interrupted_ = true;
    if (ends.empty()) return done();
    const auto end = ends.front();
    ends.pop_front();
    interrupted_ = end == nullptr;
    if (end != nullptr && on_event) on_event(end);
    return done();
  }
  bool interrupted() const override { return interrupted_; }
  void resume() override { interrupted_ = false; }
  Output& out() override { return out_; }
  std::vector<client::Device> devices() override { return listed; }

  std::deque<json> ends;  ///< an event of the network, or null: a signal
  std::vector<client::Device> listed;
  std::vector<json> sent;
  int waits = 0;

 private:
  bool interrupted_ = false;
  Output out_;
};

class ZigbeeToolLine : public testing::Test {
 protected:
  ZigbeeToolLine() : file_(std::tmpfile()), tool_(make()) {}
  ~ZigbeeToolLine() override { std::fclose(file_); }

  static json closed(const std::string& why = {}) {
    json event{{"id", "1"}, {"event", "closed"}};
    if (!why.empty()) event["why"] = why;
    return event;
  }
  static json ready(const std::string& name) { return {{"id", "1"}, {"event", "interviewed"}, {"name", name}}; }
  std::string output() {
    tool_.out().flush();
    std::rewind(file_);
    std::string text(10'000, '\0');
    text.resize(std::fread(text.data(), 1, text.size(), file_));
    return text;
  }

  std::FILE* file_;
  PreparedLine* line_ = nullptr;  ///< the tool's
  Tool tool_;

 private:
  Tool make() {
    auto line = std::make_unique<PreparedLine>(::fileno(file_));
    line_ = line.get();
    return {std::move(line), false};
  }
};

TEST_F(ZigbeeToolLine, APermitEndsWhenJoiningIsClosed) {
  line_->ends = {closed()};
  EXPECT_EQ(watch_joins(tool_, "1"), kGood);
  EXPECT_THAT(line_->sent, IsEmpty()) << "it is closed already";
  EXPECT_EQ(output(), "joining is closed; 0 new devices ready\n");
}

TEST_F(ZigbeeToolLine, AnInterruptClosesJoiningAndTheProgramWaitsUntilItIs) {
  line_->ends = {nullptr, closed()};
  EXPECT_EQ(watch_joins(tool_, "1"), kGood);
  EXPECT_THAT(line_->sent, ElementsAre(json({{"do", "permit"}, {"seconds", 0}})));
  EXPECT_EQ(line_->waits, 2);
}

/// A terminal sends an interrupt to the whole group, and `timeout` or a script once more to the program.
TEST_F(ZigbeeToolLine, ASecondSignalOfTheSameInterruptDoesNotEndTheWait) {
  line_->ends = {nullptr, nullptr, closed()};
  EXPECT_EQ(watch_joins(tool_, "1"), kGood);
  EXPECT_THAT(line_->sent, ElementsAre(json({{"do", "permit"}, {"seconds", 0}}))) << "once";
  EXPECT_EQ(line_->waits, 3);
  EXPECT_THAT(output(), HasSubstr("joining is closed"));
}

TEST_F(ZigbeeToolLine, FurtherSignalsEndTheProgram) {
  testing::internal::CaptureStderr();
  EXPECT_EQ(watch_joins(tool_, "1"), kNotDone);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("did not confirm that joining is closed"));
  EXPECT_EQ(line_->waits, 4) << "the watch, and three waits for the end";
  EXPECT_EQ(output(), "");
}

TEST_F(ZigbeeToolLine, ThePermitPrintsTheReasonWhyItEndedEarly) {
  line_->ends = {closed("the bridge went offline")};
  testing::internal::CaptureStderr();
  EXPECT_EQ(watch_joins(tool_, "1"), kNotDone);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("the bridge went offline"));
}

TEST_F(ZigbeeToolLine, DevicesThatJoinWhileItClosesAreShown) {
  line_->ends = {nullptr, ready("porch"), closed()};
  EXPECT_EQ(watch_joins(tool_, "1"), kGood);
  EXPECT_THAT(output(), testing::AllOf(HasSubstr("porch is ready"), HasSubstr("1 new device ready")));
}

TEST_F(ZigbeeToolLine, EventsOfAnotherPermitAreNotShown) {
  auto other = ready("porch"), end = closed();
  other["id"] = end["id"] = "2";
  line_->ends = {nullptr, other, end, closed()};
  EXPECT_EQ(watch_joins(tool_, "1"), kGood);
  EXPECT_EQ(output(), "joining is closed; 0 new devices ready\n");
}

TEST_F(ZigbeeToolLine, ARequestNamesADeviceByTheWordAndByTheAddressThatTheIslandHasForIt) {
  client::Device bath;
  bath.id = "bath";
  bath.name = "Bath room";
  bath.address = "00124b0010000009";
  line_->listed = {bath};
  for (const auto* word : {"bath", "Bath room", "00124b0010000009"}) {
    json request;
    EXPECT_EQ(tool_.name_device(request, "device", word), kGood);
    EXPECT_EQ(request, json({{"device", word}, {"address", "00124b0010000009"}}));
  }
  json request;
  EXPECT_EQ(tool_.name_device(request, "via", "hall/lamp"), kGood);
  EXPECT_EQ(request, json({{"via", "hall/lamp"}})) << "the bridge may know it";
}

TEST_F(ZigbeeToolLine, AWordThatMeansSeveralDevicesIsRefused) {
  client::Device one, other;
  one.id = "a";
  other.id = "b";
  one.name = other.name = "Lamp";
  line_->listed = {one, other};
  json request;
  testing::internal::CaptureStderr();
  EXPECT_EQ(tool_.name_device(request, "device", "Lamp"), kUsage);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("'Lamp' is ambiguous"));
}

}  // namespace
}  // namespace rubicon::cli::zigbee
