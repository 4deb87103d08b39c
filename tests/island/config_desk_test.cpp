#include "island/config_desk.h"

#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "config/yaml.h"
#include "island/network_types.h"
#include "island/virtual_island.h"
#include "support/folder.h"

namespace rubicon::island {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::UnorderedElementsAre;
using tuples::Verdict;

constexpr const char* kHallOfTheDesk = "{hall: {sensors: {temperature-1: {wave: constant, value: 21}}}}";
constexpr const char* kGroups = "groups:\n  1/0/1: {dpt: 1.001, kind: actuator, name: Lamp}\n";

std::string content(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void write(const std::string& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

/// An island with a file on the disk.
class Desk : public testing::Test {
 protected:
  Desk() {
    write(path, file);
    ::chmod(path.c_str(), 0640);
    desk.took(file);
    island.settings().on_reload([this](bool) { return reload(); });
    island.settings().change_by(desk);
    everything = space.subscribe({kHome, "proxy.settings.*"}, {.passive = true}, [](const tuples::Event&) {});
    time.run_for(1s);
  }

  /// The networks of this island read their files in memory.
  Result<IslandConfig> load(const std::string& text, base::ConfigErrors& errors) {
    for (const auto& one : std::filesystem::directory_iterator(folder.path()))
      home.files.put(one.path().string(), std::string_view(content(one.path().string())));
    const auto other =
        std::filesystem::temp_directory_path() / (".rubicon-" + std::to_string(::getpid()) + ".groups.yaml");
    if (std::filesystem::exists(other)) home.files.put(other.string(), std::string_view(content(other.string())));
    auto tree = config::parse_yaml(text, "home.yaml");
    if (!tree) return fail(tree.error());
    auto next = read_island_config(std::move(*tree), network_types(), errors);
    next.directory = folder.path();
    if (!errors.empty()) return fail(ErrorCode::kInvalid, errors.text());
    return next;
  }
  Result<ConfigDesk::Lines> plan(const std::string& text) {
    base::ConfigErrors errors;
    const auto next = load(text, errors);
    if (!next) return fail(next.error());
    const auto plan = island.plan(*next, errors);
    return plan ? Result<ConfigDesk::Lines>(plan->lines) : fail(plan.error());
  }
  Result<ConfigDesk::Lines> reload() {
    if (refuses) return fail(ErrorCode::kRefused, "not now");
    base::ConfigErrors errors;
    const auto text = content(path);
    auto next = load(text, errors);
    if (!next) return fail(next.error());
    const auto plan = island.reload(std::move(*next), errors);
    if (!plan) return fail(plan.error());
    desk.took(text);
    return plan->lines;
  }

  tuples::Reply command(std::string_view text) {
    tuples::Reply got;
    std::ignore =
        space.set_remote(kHome, "proxy.settings.command", text, 5s, [&](const tuples::Reply& reply) { got = reply; });
    time.run_for(100ms);
    return got;
  }
  tuples::Reply change(const json& what) { return command(what.dump()); }
  json status() {
    const auto tuple = space.get(kHome, "proxy.settings.status");
    return json::parse(tuple ? std::string(tuple->value) : "", nullptr, false);
  }
  std::vector<std::string> names() const {
    std::vector<std::string> all;
    for (const auto& one : std::filesystem::directory_iterator(folder.path()))
      all.push_back(one.path().filename().string());
    return all;
  }
  std::vector<std::string> networks() { return island.networks().ids(); }

  static constexpr OwnerId kHome{6541};
  support::Folder folder;
  std::string path = folder / "home.yaml";
  std::string file =
      std::string("# ours\nisland: {id: 6541, name: home}\nnetworks:\n  dummy-1: {type: dummy, simulate: ") +
      kHallOfTheDesk + "}\n# the end\n";
  VirtualIsland home{kHallOfTheDesk};
  VirtualScheduler& time = home.time;
  TupleSpace& space = *home.space;
  Island& island = *home.island;
  bool refuses = false;
  ConfigDesk desk{path,
                  {[this](const std::string& text) { return plan(text); }, [this] { return reload(); },
                   [](const std::string& network) { return network == "by-the-command-line"; }}};
  tuples::Handle everything;
};

const json kAdd{{"do", "add"}, {"network", "dummy-2"}, {"options", "type: dummy\nsimulate: {shed: {name: Shed}}\n"}};

TEST_F(Desk, ATryNamesTheChangeAndThePatchAndWritesNothing) {
  auto what = kAdd;
  what["try"] = true;
  EXPECT_EQ(change(what).verdict, Verdict::kApplied);
  EXPECT_EQ(status()["what"], "add");
  EXPECT_EQ(status()["tried"], true);
  EXPECT_EQ(status()["state"], "ok") << status();
  EXPECT_EQ(status()["changes"], json({"network dummy-2: is added"}));
  EXPECT_EQ(status()["file"]["patch"], "networks:\n  dummy-2:\n    type: dummy\n    simulate: {shed: {name: Shed}}\n");
  EXPECT_EQ(status()["file"]["name"], "home.yaml");
  EXPECT_EQ(status()["file"]["previous"], false);
  EXPECT_EQ(content(path), file);
  EXPECT_THAT(names(), ElementsAre("home.yaml"));
  EXPECT_THAT(networks(), ElementsAre("dummy-1"));
}

TEST_F(Desk, ANetworkIsAddedBesideThePreviousFileAndTakenBack) {
  EXPECT_EQ(change(kAdd).verdict, Verdict::kApplied);
  EXPECT_EQ(status()["command"]["state"], "confirmed") << status();
  EXPECT_THAT(networks(), ElementsAre("dummy-1", "dummy-2"));
  auto expected = file;
  expected.insert(expected.find("# the end"), "  dummy-2:\n    type: dummy\n    simulate: {shed: {name: Shed}}\n");
  EXPECT_EQ(content(path), expected);
  EXPECT_EQ(content(path + ".previous"), file);
  struct stat about {};
  ASSERT_EQ(::stat(path.c_str(), &about), 0);
  EXPECT_EQ(about.st_mode & 0777U, 0640U);
  EXPECT_THAT(names(), UnorderedElementsAre("home.yaml", "home.yaml.previous"));

  command("undo");
  EXPECT_EQ(status()["what"], "undo");
  EXPECT_EQ(status()["changes"], json({"network dummy-2: is removed with its devices"})) << status();
  EXPECT_EQ(content(path), file);
  EXPECT_THAT(networks(), ElementsAre("dummy-1"));
  command("undo");
  EXPECT_EQ(content(path), expected);
  EXPECT_THAT(networks(), ElementsAre("dummy-1", "dummy-2"));
}

TEST_F(Desk, AnImportWritesAGroupFileOfItsOwnNameEachTime) {
  change({{"do", "add"}, {"network", "knx"}, {"options", "type: knx\nhost: 127.0.0.1\n"}, {"groups", kGroups}});
  EXPECT_EQ(status()["state"], "ok") << status();
  EXPECT_EQ(content(folder / "knx.groups.yaml"), kGroups);
  EXPECT_THAT(content(path), HasSubstr("  knx:\n    import: knx.groups.yaml\n    type: knx\n    host: 127.0.0.1\n"));
  const std::string more = "groups:\n  1/0/1: 1.001\n  1/0/2: 9.001\n";
  change({{"do", "import"}, {"network", "knx"}, {"groups", more}});
  EXPECT_EQ(status()["changes"].size(), 1U) << status();
  EXPECT_EQ(content(folder / "knx.groups.yaml"), kGroups);
  EXPECT_EQ(content(folder / "knx.groups-2.yaml"), more);
  EXPECT_THAT(content(path), HasSubstr("import: knx.groups-2.yaml\n"));
  command("undo");
  EXPECT_THAT(content(path), HasSubstr("import: knx.groups.yaml\n"));
}

TEST_F(Desk, WhatCheckFindsIsSaidWithItsPlaceAndNothingIsWritten) {
  change({{"do", "add"}, {"network", "knx"}, {"options", "type: knx\n"}, {"groups", kGroups}});
  EXPECT_EQ(status()["state"], "refused");
  ASSERT_EQ(status()["errors"].size(), 1U) << status();
  EXPECT_EQ(status()["errors"][0]["line"], 6);
  EXPECT_THAT(status()["errors"][0]["text"].get<std::string>(), HasSubstr("'host' is missing"));
  change({{"do", "add"},
          {"network", "knx"},
          {"options", "type: knx\nhost: 127.0.0.1\n"},
          {"groups", "groups: {1/0/1: 77.1}"}});
  EXPECT_EQ(status()["state"], "refused");
  change({{"do", "add"}, {"network", "dummy-1"}, {"options", "type: dummy\n"}});
  EXPECT_THAT(status()["errors"][0]["text"].get<std::string>(), HasSubstr("there is a network dummy-1 already"));
  change({{"do", "add"}, {"network", "by-the-command-line"}, {"options", "type: dummy\n"}});
  EXPECT_EQ(status()["state"], "refused");
  EXPECT_EQ(content(path), file);
  EXPECT_THAT(names(), ElementsAre("home.yaml"));
}

TEST_F(Desk, AFileThatIsNotInForceIsNotChanged) {
  write(path, file + "limits: {queue: 50}\n");
  change(kAdd);
  EXPECT_EQ(status()["command"]["state"], "refused");
  EXPECT_THAT(status()["command"]["reason"].get<std::string>(), HasSubstr("is not in force: reload it first"));
  EXPECT_THAT(networks(), ElementsAre("dummy-1"));
  command("reload");
  change(kAdd);
  EXPECT_EQ(status()["command"]["state"], "confirmed") << status();
  EXPECT_THAT(content(path), HasSubstr("dummy-2"));
  EXPECT_THAT(content(path), HasSubstr("limits: {queue: 50}"));
}

TEST_F(Desk, AReloadThatIsRefusedLeavesAllFilesAsTheyWere) {
  change(kAdd);
  const auto before = content(path);
  refuses = true;
  change({{"do", "add"}, {"network", "knx"}, {"options", "type: knx\nhost: 127.0.0.1\n"}, {"groups", kGroups}});
  EXPECT_EQ(status()["errors"][0]["text"], "not now");
  EXPECT_EQ(content(path), before);
  EXPECT_EQ(content(path + ".previous"), file);
  EXPECT_THAT(names(), UnorderedElementsAre("home.yaml", "home.yaml.previous"));
}

TEST_F(Desk, ALinkStaysALinkToTheFileThatIsChanged) {
  const auto real = folder / "real.yaml";
  std::filesystem::rename(path, real);
  std::filesystem::create_symlink("real.yaml", path);
  change(kAdd);
  EXPECT_TRUE(std::filesystem::is_symlink(path));
  EXPECT_THAT(content(real), HasSubstr("dummy-2"));
  EXPECT_EQ(content(real + ".previous"), file);
}

TEST_F(Desk, AFolderThatCannotBeWrittenLeavesThePatch) {
  const auto user = ::geteuid();
  std::filesystem::permissions(folder.path(), std::filesystem::perms(0555));
  std::filesystem::permissions(path, std::filesystem::perms(0644));
  if (user == 0) {
    ASSERT_EQ(::seteuid(65534), 0);  // root may write everywhere
  }
  change({{"do", "add"},
          {"network", "knx"},
          {"options", "type: knx\nhost: 127.0.0.1\n"},
          {"groups", kGroups},
          {"try", true}});
  EXPECT_EQ(status()["state"], "ok") << status();
  EXPECT_THAT(status()["file"]["fixed"].get<std::string>(), HasSubstr("Permission denied"));
  change(kAdd);
  EXPECT_THAT(status()["command"]["reason"].get<std::string>(), HasSubstr("insert the patch yourself"));
  EXPECT_THAT(status()["file"]["patch"].get<std::string>(), HasSubstr("dummy-2"));
  ASSERT_EQ(::seteuid(user), 0);
  std::filesystem::permissions(folder.path(), std::filesystem::perms(0750));
  EXPECT_EQ(content(path), file);
}

TEST_F(Desk, WithoutAPreviousFileThereIsNothingToTakeBack) {
  command("undo");
  EXPECT_THAT(status()["command"]["reason"].get<std::string>(), HasSubstr("there is no previous file"));
}

TEST_F(Desk, WhatIsNoChangeIsRefusedAtOnce) {
  for (const auto* text : {"{", "{}", "{\"do\":\"delete\"}", "{\"do\":\"add\"}", "{\"do\":\"add\",\"network\":\"x\"}",
                           "{\"do\":\"import\",\"network\":\"x\"}", "{\"do\":\"undo\",\"try\":\"yes\"}",
                           "{\"do\":\"undo\",\"more\":1}", "{\"do\":7}", "[]", "undo it"}) {
    EXPECT_EQ(command(text).verdict, Verdict::kRefused) << text;
  }
  EXPECT_EQ(change({{"do", "add"}, {"network", "x"}, {"options", std::string(65 * 1024, 'a')}}).verdict,
            Verdict::kRefused);
  EXPECT_EQ(status()["state"], "idle");
}

TEST_F(Desk, TheStatusShowsOnlyTheBeginningOfALongCommand) {
  change({{"do", "add"},
          {"network", "knx"},
          {"options", "type: knx\nhost: 127.0.0.1\n"},
          {"groups", std::string(kGroups) + "# " + std::string(5000, 'x')}});
  EXPECT_LT(status()["command"].dump().size(), 500U) << status();
}

TEST_F(Desk, TheSamplesOfAllTypesAreATuple) {
  const auto samples = json::parse(space.get(kHome, "proxy.settings.networks")->value);
  ASSERT_EQ(samples.size(), network_types().size());
  EXPECT_EQ(samples[0]["type"], network_types()[0].name);
  EXPECT_EQ(samples[0]["sample"], network_types()[0].sample_config);
}

}  // namespace
}  // namespace rubicon::island
