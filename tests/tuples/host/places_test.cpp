#include "tuples/host/places.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>

#include "support/folder.h"

namespace rubicon::tuples::host {
namespace {

struct HostPlaces : testing::Test {
  support::Folder folder;
  Surroundings around{folder / "installed", {}, {}, folder.path()};
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

}  // namespace
}  // namespace rubicon::tuples::host
