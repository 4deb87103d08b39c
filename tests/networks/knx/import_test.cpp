#include "networks/knx/bench.h"
#include "support/knx_project.h"

namespace rubicon::networks::knx {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

class KnxImports : public KnxBench {
 protected:
  /// The errors of a network with these options.
  std::string errors_of(std::string_view options) {
    const ConfigNode node = support::config_of(options);
    base::ConfigErrors found;
    ConfigReader reader(node, "networks.knx", found);
    const auto made = kType.make({"knx", IslandId{1}, reader, types, {}}, host);
    reader.finish();
    EXPECT_EQ(made.has_value(), found.empty());
    return found.text();
  }

  static std::string house(const std::string& password) {
    auto house = support::small_house(23);
    house.password = password;
    return house.file();
  }
};

TEST_F(KnxImports, AProjectGivesTheDevices) {
  host.files.put("house.knxproj", house(""));
  start(R"({"host": "10.0.0.9", "import": "house.knxproj", "groups": {"1/1/1": "1.008"}})");
  const auto joins = host.all<model::Join>();
  ASSERT_THAT(joins, SizeIs(6));
  EXPECT_EQ(joins[0].first, "1/0/1");
  EXPECT_EQ(joins[0].second.name, "Kitchen lamp");
  EXPECT_EQ(joins[0].second.area, "Ground floor / Kitchen");
  server.inject(0x1105, group("2/0/3"), 0x80, {0x0c, 0x33});
  host.time.run_for(1s);
  EXPECT_THAT(values_of("2/0/2"), ElementsAre("21.5")) << "on its state address";
}

TEST_F(KnxImports, ADeviceIsInTheRoomOfItsPointsIfThatIsOne) {
  start(R"({"host": "10.0.0.9", "groups": {
    "1/0/1": {"dpt": "1.001", "device": "a", "room": "Hall"}, "1/0/2": {"dpt": "9.001", "device": "a"},
    "1/0/3": {"dpt": "1.001", "device": "b", "room": "Hall"}, "1/0/4": {"dpt": "9.001", "device": "b", "room": "Bath"},
    "1/0/5": {"dpt": "5.001", "device": "b", "room": "Hall"}}})");
  const auto joins = host.all<model::Join>();
  ASSERT_THAT(joins, SizeIs(2));
  EXPECT_EQ(joins[0].second.area, "Hall");
  EXPECT_EQ(joins[1].second.area, "");
}

TEST_F(KnxImports, AProtectedProjectTakesItsPasswordFromAFile) {
  host.files.put("house.knxproj", house("flatpass"));
  host.files.put("right", "flatpass\n");
  host.files.put("wrong", "other\n");
  host.files.put("open", "flatpass\n");
  host.files.open_to_all("open");
  EXPECT_EQ(errors_of(R"({"host": "10.0.0.9", "import": "house.knxproj", "import-password-file": "right"})"), "");
  EXPECT_THAT(
      errors_of(R"({"host": "10.0.0.9", "import": "house.knxproj"})"),
      HasSubstr("house.knxproj: the project P-00F1 is protected by a password, and none was given: write it to a "
                "file and name that in 'import-password-file'"));
  EXPECT_THAT(errors_of(R"({"host": "10.0.0.9", "import": "house.knxproj", "import-password-file": "wrong"})"),
              HasSubstr("house.knxproj: the password of the project P-00F1 is wrong (the password is from wrong)"));
  EXPECT_THAT(errors_of(R"({"host": "10.0.0.9", "import": "house.knxproj", "import-password-file": "open"})"),
              HasSubstr("run chmod 600"));
  EXPECT_THAT(errors_of(R"({"host": "10.0.0.9", "import": "house.knxproj", "import-password-file": "none"})"),
              HasSubstr("none: "));
}

TEST_F(KnxImports, APasswordFileWithoutAProjectIsAnError) {
  host.files.put("flat.csv", "Lamp;1/0/1;;;;DPST-1-1;\n");
  host.files.put("right", "flatpass\n");
  EXPECT_THAT(errors_of(R"({"host": "10.0.0.9", "import": "flat.csv", "import-password-file": "right"})"),
              HasSubstr("is only for projects of ETS"));
  EXPECT_THAT(errors_of(R"({"host": "10.0.0.9", "import-password-file": "right"})"),
              HasSubstr("is given without 'import'"));
}

}  // namespace
}  // namespace rubicon::networks::knx
