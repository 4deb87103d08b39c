#include "tuples/host/folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "support/folder.h"

namespace rubicon::tuples::host {
namespace {

struct HostPlaces : testing::Test {
  support::Folder folder;
  Surroundings around{folder / "installed", {}, {}, {}, folder.path(), folder / "people"};
  const std::string uid = std::to_string(::geteuid());

  std::string chosen(const std::string& configured = {}) { return choose_place(configured, around)->path; }
};

TEST_F(HostPlaces, AreTakenInTheirOrder) {
  EXPECT_EQ(chosen(), folder.path() + "/rubicon-" + uid);
  std::filesystem::create_directory(folder / "runtime");
  around.runtime = folder / "runtime";
  EXPECT_EQ(chosen(), folder / "runtime/rubicon");
  std::filesystem::create_directories(folder / "installed/islands");
  EXPECT_EQ(chosen(), folder / "installed");
  EXPECT_TRUE(choose_place({}, around)->shared);
  around.beside = folder / "demo";
  EXPECT_EQ(chosen(), folder / "demo");
  EXPECT_EQ(chosen("/srv/meet"), "/srv/meet");
  around.given = "/given";
  EXPECT_EQ(chosen("/srv/meet"), "/given");
  EXPECT_FALSE(choose_place({}, around)->shared);
}

TEST_F(HostPlaces, SkipARuntimeFolderThatIsNotThere) {
  around.runtime = folder / "nowhere";
  EXPECT_EQ(chosen(), folder.path() + "/rubicon-" + uid);
}

TEST_F(HostPlaces, AreAbsolutePaths) {
  const auto wrong = choose_place("meet/here", around);
  EXPECT_EQ(wrong.error().code, ErrorCode::kInvalid);
  EXPECT_EQ(wrong.error().text, "tuples.folder: meet/here: expected an absolute path");
}

/// Anybody may make a folder with another user's number.
TEST_F(HostPlaces, ElsewhereAreNamedWhereSocketsOfTheirUsersStand) {
  const std::string socket = "/default/0000000000000001.sock";
  const auto own = folder / "people/" + uid + "/rubicon";
  for (const auto& path : {own, folder / "people/4711/rubicon", folder / "rubicon-4712", folder / "rubicon-" + uid,
                           folder / "installed/people/1000"}) {
    std::filesystem::create_directories(path + "/default");
    std::ofstream(path + socket) << "";
  }
  EXPECT_THAT(other_places(folder / "nowhere", around),
              testing::UnorderedElementsAre(folder / "installed", own, folder / "rubicon-" + uid));
  std::filesystem::remove(own + socket);
  EXPECT_THAT(other_places(folder / "rubicon-" + uid, around), testing::ElementsAre(folder / "installed"));
  EXPECT_FALSE(is_shut_out(around)) << "root and the owner may enter it";
}

}  // namespace
}  // namespace rubicon::tuples::host
