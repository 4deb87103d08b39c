#include "apps/rubicon-proxy/state_tool.h"

#include <gmock/gmock.h>

#include "state/state_export.h"
#include "state/state_support.h"

namespace rubicon::daemon {
namespace {

namespace fs = std::filesystem;
using state::at;
using state::device_of;
using state::Folder;
using state::kIsland;
using state::opened;
using state::read_all;
using state::sensor;
using state::snapshot;
using state::StateStore;
using state::value_at;
using state::write_all;
using testing::HasSubstr;

/// Devices with everything that is hard to write down.
void fill(StateStore& store) {
  for (int i = 0; i < 4; ++i) {
    auto device = device_of("wsn-1", std::to_string(9 - i));
    device.decision = static_cast<state::Decision>(i % 3);
    device.first_seen = at(-i);
    device.values = {value_at(sensor(1), 21.5 + i, 100),
                     value_at(sensor(1, "2"), {}, 2),
                     value_at({Kind::kActuator, TypeId(3), "1"}, true, 2),
                     value_at({Kind::kActuator, TypeId(3), "2"}, std::int64_t{-7}, 2),
                     value_at({Kind::kProperty, TypeId(4), ""}, std::string("two\nlines \xe2\x82\xac"), 2),
                     value_at({Kind::kProperty, TypeId(4), "a"}, std::string("\xff\0no text", 9), 2),
                     value_at({Kind::kProperty, TypeId(4), "b"}, model::Json{R"({"hex":"00"})"}, 2)};
    device.values[0].user_time = at(7);
    device.values[4].set_by_user = true;
    if (i == 2)
      device.given_name =
          "K\xc3\xbc"
          "che \"2\"",
      device.area = "Oben";
    ASSERT_TRUE(store.save(device));
  }
  auto odd = device_of("knx-\xfe", "1/4/6");
  odd.id = "";
  odd.join.name =
      "K\xfc"
      "che";
  odd.join.heard = false;
  odd.join.capabilities[0].initial = std::string("x");
  odd.first_seen = odd.last_heard = {};
  ASSERT_TRUE(store.save(odd));
}

class StateTool : public testing::Test {
 protected:
  StateTool() { fill(*opened(file_)); }

  int import(const std::string& file, const std::string& content, bool force = false) {
    write_all(folder_ / "in", content);
    testing::internal::CaptureStderr();
    testing::internal::CaptureStdout();
    const auto code = import_state(file, folder_ / "in", force);
    output_ = testing::internal::GetCapturedStdout();
    errors_ = testing::internal::GetCapturedStderr();
    return code;
  }
  std::string exported(const std::string& file) {
    EXPECT_EQ(export_state(file, folder_ / "out"), 0);
    return read_all(folder_ / "out");
  }
  int quietly(const std::function<int()>& tool) {
    testing::internal::CaptureStderr();
    testing::internal::CaptureStdout();
    const auto code = tool();
    output_ = testing::internal::GetCapturedStdout();
    errors_ = testing::internal::GetCapturedStderr();
    return code;
  }

  Folder folder_;
  std::string file_ = folder_ / "s";
  std::string output_, errors_;
};

TEST_F(StateTool, AnExportImportedIntoANewFileGivesAnEqualExport) {
  const auto first = exported(file_);
  ASSERT_EQ(import(folder_ / "new", first), 0) << errors_;
  EXPECT_THAT(output_, HasSubstr("5 devices imported, 5 remembered now"));
  EXPECT_EQ(exported(folder_ / "new"), first);
  EXPECT_EQ(snapshot(*opened(folder_ / "new")), snapshot(*opened(file_)));
}

TEST_F(StateTool, AnImportMergesIntoWhatIsThere) {
  const auto other = opened(folder_ / "other");
  auto device = device_of("wsn-1", "9");
  device.id = "renamed";
  device.values = {value_at(sensor(1), 99.0, 500)};
  ASSERT_TRUE(other->save(device));
  ASSERT_TRUE(other->save(device_of("wsn-1", "new")));
  ASSERT_EQ(import(file_, exported(folder_ / "other")), 0) << errors_;
  const auto store = opened(file_);
  EXPECT_EQ(store->stats().devices, 6U);
  const auto merged = **store->find("wsn-1", "9");
  EXPECT_EQ(merged.id, "renamed");
  EXPECT_EQ(merged.values.size(), 7U);
  EXPECT_EQ(merged.values[0], device.values[0]);
}

TEST_F(StateTool, AnExportOfAnotherIslandIsRefusedUnlessForced) {
  const auto file = folder_ / "seven";
  StateStore::open(file, IslandId(7))->reset();
  const auto before = exported(file);
  EXPECT_EQ(import(file, exported(file_)), 1);
  EXPECT_THAT(errors_, HasSubstr("of island 7, the export is of island 6541"));
  EXPECT_EQ(exported(file), before);
  EXPECT_EQ(import(file, exported(file_), true), 0) << errors_;
  EXPECT_THAT(exported(file), HasSubstr("\"island\":7"));
}

TEST_F(StateTool, AWrongImportChangesNothingAndNamesEveryWrongLine) {
  auto content = exported(file_);
  const auto before = content;
  const auto replace = [&content](const std::string& what, const std::string& by) {
    const auto found = content.find(what);
    ASSERT_NE(found, content.npos) << what;
    content.replace(found, what.size(), by);
  };
  replace("\"wsn-1\"", "\"new\"");
  replace("\"kind\":\"actuator\"", "\"kind\":\"lamp\"");       // line 2
  replace("\"decision\":\"approved\"", "\"decision\":\"x\"");  // line 3
  replace("\"devices\":5", "\"devices\":6");                   // line 7
  EXPECT_EQ(import(file_, content), 1);
  EXPECT_THAT(errors_, HasSubstr("line 2: values[2].kind: expected sensor, actuator or property"));
  EXPECT_THAT(errors_, HasSubstr("line 3: decision: expected none, approved or ignored"));
  EXPECT_THAT(errors_, HasSubstr("line 7: the export was written with another number of devices than the 5"));
  EXPECT_THAT(errors_, HasSubstr("nothing was imported"));
  EXPECT_EQ(exported(file_), before);
  EXPECT_EQ(import(folder_ / "new", content), 1);
  EXPECT_FALSE(fs::exists(folder_ / "new"));
}

TEST_F(StateTool, AnImportCutAnywhereChangesNothing) {
  const auto whole = exported(file_);
  for (std::size_t size = 0; size < whole.size() - 1; size += 97) {
    ASSERT_EQ(import(folder_ / "new", whole.substr(0, size)), 1) << size;
    ASSERT_THAT(errors_, HasSubstr("line")) << size;
    ASSERT_FALSE(fs::exists(folder_ / "new")) << size;
  }
}

TEST_F(StateTool, AnImportThatIsNoneIsRefused) {
  const auto head = state::export_head(kIsland) + "\n";
  const auto line = state::export_line(device_of("wsn-1", "1")) + "\n";
  for (const std::string& content :
       {std::string(), std::string("hello\n"), std::string("{}\n"), std::string("{\"rubicon-state\":2,\"island\":1}\n"),
        std::string("{\"rubicon-state\":1,\"island\":0}\n"), head + "[]\n", head + std::string(100, '['),
        head + line + line + state::export_end(2), head + state::export_end(0) + "\n" + line,
        head + "{\"network\":\"a\"}\n", head + "\n" + state::export_end(0)}) {
    EXPECT_EQ(import(file_, content), 1) << content;
    EXPECT_NE(errors_, "") << content;
  }
  EXPECT_EQ(opened(file_)->stats().devices, 5U);
}

TEST_F(StateTool, AnImportThatIsNestedTooDeepIsNotParsed) {
  const auto head = state::export_head(kIsland) + "\n";
  const auto deep = std::string(17, '[');
  for (const auto& line : {deep, "]]]]" + deep, "{\"a\":" + std::string(16, '{')}) {
    EXPECT_EQ(import(folder_ / "new", head + line), 1);
    EXPECT_THAT(errors_, HasSubstr("line 2: nested deeper, expected at most 16 levels")) << line;
  }
}

TEST_F(StateTool, ChangesNothingWhileAnIslandHasTheFileButReads) {
  const auto content = exported(file_);
  const auto before = snapshot(*opened(file_));
  const auto daemon = opened(file_);
  EXPECT_EQ(import(file_, content), 1);
  EXPECT_THAT(errors_, HasSubstr("another process has it open"));
  EXPECT_EQ(quietly([&] { return forget_state(file_, {"wsn-1/9"}); }), 1);
  EXPECT_EQ(exported(file_), content);
  EXPECT_EQ(quietly([&] { return show_state(file_); }), 0);
  EXPECT_EQ(snapshot(*daemon), before);
}

TEST_F(StateTool, ShowsATableOfTheDevices) {
  EXPECT_EQ(quietly([&] { return show_state(file_); }), 0);
  EXPECT_THAT(output_, HasSubstr("island 6541, 5 devices, 28 values"));
  EXPECT_THAT(output_, testing::ContainsRegex("wsn-1/8 +id_8 +approved +2026-09-21 [0-9:]+ +7\n"));
  EXPECT_THAT(output_, testing::ContainsRegex("1/4/6 +none +never +0\n"));
  EXPECT_EQ(quietly([&] { return show_state(folder_ / "none"); }), 1);
  EXPECT_THAT(errors_, HasSubstr("does not exist"));
}

TEST_F(StateTool, ForgetsDevicesByAddressOrKeyAllOrNone) {
  EXPECT_EQ(quietly([&] { return forget_state(file_, {"wsn-1/9", "wsn-1/none"}); }), 1);
  EXPECT_THAT(errors_, HasSubstr("wsn-1/none: no such device"));
  EXPECT_EQ(opened(file_)->stats().devices, 5U);
  EXPECT_EQ(quietly([&] { return forget_state(file_, {"wsn-1/9", "wsn-1.id_8", "proxy.wsn-1.id_7"}); }), 0) << errors_;
  EXPECT_EQ(quietly([&] { return forget_state(file_, {"knx-\xfe/1/4/6"}); }), 0) << errors_;
  EXPECT_EQ(opened(file_)->stats().devices, 1U);
}

TEST_F(StateTool, ShowsAndForgetsWhatNetworksRemember) {
  EXPECT_EQ(quietly([&] { return show_state(file_); }), 0);
  EXPECT_THAT(output_, testing::Not(HasSubstr("NETWORK "))) << "none of them remembers anything";
  for (const auto* name : {"secure.sequence", "routing-timer"})
    ASSERT_TRUE(opened(file_)->remember("knx-hall", name, Bytes(8), 9));
  ASSERT_TRUE(opened(file_)->remember("knx-shed", "secure.sequence", Bytes(8), 9));
  EXPECT_EQ(quietly([&] { return show_state(file_); }), 0);
  EXPECT_THAT(output_, testing::ContainsRegex("knx-hall +2 +16\nknx-shed +1 +8\n"));
  EXPECT_EQ(quietly([&] { return forget_state(file_, {"knx-hall", "knx-none"}); }), 1);
  EXPECT_THAT(errors_, HasSubstr("network knx-none remembers nothing"));
  EXPECT_TRUE(opened(file_)->remembered("knx-hall", "routing-timer")->has_value());
  EXPECT_EQ(quietly([&] { return forget_state(file_, {"knx-hall"}); }), 0) << errors_;
  EXPECT_FALSE(opened(file_)->remembered("knx-hall", "routing-timer")->has_value());
  EXPECT_TRUE(opened(file_)->remembered("knx-shed", "secure.sequence")->has_value());
  EXPECT_EQ(opened(file_)->stats().devices, 5U);
}

}  // namespace
}  // namespace rubicon::daemon
