#include <fmt/format.h>
#include <gmock/gmock.h>

#include <fstream>
#include <set>
#include <sstream>

#include "tuples/dds/trust/trusted_members.h"

namespace rubicon::tuples::dds {
namespace {

const std::string kCases = RUBICON_SOURCE_DIR "/tests/cases/rights/";
const Person kRobot{"robot", kDesk.ids, kDesk.grant, 0xde};
constexpr const char* kDone = "proxy.done";

struct Row {
  std::string right, key, answer;
};

/// What the table of cases says of the robot, but for messages.
std::vector<Row> rows_of_robot() {
  std::ifstream table(kCases + "table.txt");
  std::vector<Row> rows;
  for (std::string line; std::getline(table, line);) {
    std::istringstream words(line);
    std::string member;
    Row row;
    if (words >> member >> row.right >> row.key >> row.answer && member == "robot" && row.right != "send")
      rows.push_back(row);
  }
  return rows;
}

struct RightsOverDds : TrustedMembers {
  /// An island with the tuples of all rows and the rules of the cases, and a robot that asks for all it has.
  void start() {
    island = home();
    robot = member(kRobot, kDeskId);
    ASSERT_TRUE(until(*island, fmt::format("peer {} robot", kDeskId))) << island->errors();
    ASSERT_TRUE(until(*robot, "peer 7 home")) << robot->errors();
    std::set<std::string> keys{kDone};
    for (const auto& row : rows_of_robot()) keys.insert(row.key);
    for (const auto& key : keys) island->write("owns " + key + "\n");
    ASSERT_EQ(ask(*island, "rules " + kCases + "home.yaml"), "11");
    robot->write("sees 7:**\n");
    ASSERT_TRUE(until(*robot, std::string("value 7 ") + kDone + " 1"));
  }
  std::string answer(const Row& row) {
    if (row.right == "demand") return ask(*island, "wanted " + row.key);
    return ask(*robot, (row.right == "read" ? "has 7 " : "try 7 ") + row.key);
  }
  std::unique_ptr<Process> island, robot;
};

TEST_F(RightsOverDds, AnswerAsTheTableOfCasesSays) {
  start();
  const auto rows = rows_of_robot();
  ASSERT_GE(rows.size(), 15U);
  for (const auto& row : rows) {
    if (row.right == "read" && row.answer == "yes") {
      EXPECT_TRUE(until(*robot, "value 7 " + row.key + " 1"));
    }
  }
  for (const auto& row : rows) EXPECT_EQ(answer(row), row.answer) << row.right << " " << row.key;
}

TEST_F(RightsOverDds, NewRulesTakeAwayWhatTheyNoLongerAllow) {
  start();
  std::ofstream(folder_ / "none.yaml") << "rights:\n  - {who: robot, may: read, keys: [other]}\n";
  island->write("owns other\n");
  ASSERT_EQ(ask(*island, "rules " + (folder_ / "none.yaml")), "1");
  EXPECT_TRUE(until(*robot, "value 7 other 1"));
  EXPECT_EQ(ask(*robot, std::string("has 7 ") + kDone), "no");
}

}  // namespace
}  // namespace rubicon::tuples::dds
