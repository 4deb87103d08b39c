#include <gtest/gtest.h>

#include <map>
#include <regex>
#include <set>

#include "structure/tree.h"

namespace rubicon::structure {
namespace {

using Files = std::set<std::string>;

/// Headers of libraries that take a compiler more than half a second, by their beginning, and our headers that may
/// include them: bench/README.md. All others forward declare, or leave them to the .cpp file.
const std::map<std::string, Files> kSlowHeaders{
    {"nlohmann/json.hpp",
     {"src/bridges/mqtt/discovery.h", "src/model/json_members.h", "src/model/message_fields.h",
      "src/tuples/tuple_json.h", "src/client/json_forms.h", "src/island/island_commands.h", "src/verbs/answers.h",
      "src/verbs/members.h", "src/web/api/forms.h", "src/web/api/route.h", "apps/rubicon/tool_line.h",
      "apps/rubicon/output/tuple_text.h", "apps/simulators/zigbee/bridge_json.h",
      "apps/simulators/zigbee/definition_generator.h", "apps/simulators/zigbee/device_model.h",
      "apps/simulators/zigbee/script.h"}},
    {"CLI/",
     {"apps/program/usage_error.h", "apps/rubicon/cli.h", "apps/rubicon/commands/completion.h",
      "apps/rubicon/targets/options.h", "apps/rubicon/settings.h"}},
    {"boost/asio/ssl", {"src/web/server/peer_stream.h"}},
    {"boost/beast", {}},
    {"simdjson.h", {"src/networks/zigbee/bridge/json_tree.h"}},
    {"spdlog/", {}},
    {"yaml-cpp/", {}},
    {"regex", {}},
    {"iostream", {}},
};

Files slow_includes(const std::string& text) {
  static const std::regex kInclude(R"re(#[ \t]*include[ \t]*<([^>]+)>)re");
  Files found;
  for (std::sregex_iterator it(text.begin(), text.end(), kInclude), end; it != end; ++it) {
    for (const auto& [beginning, files] : kSlowHeaders) {
      if ((*it)[1].str().starts_with(beginning)) found.insert(beginning);
    }
  }
  return found;
}

TEST(BuildCost, OnlyTheseHeadersIncludeSlowOnes) {
  std::map<std::string, Files> found;
  for (const auto* folder : {"src", "apps", "include"}) {
    for (const auto& file : files_below(folder, {".h", ".hpp"})) {
      for (const auto& slow : slow_includes(file.text)) found[slow].insert(file.path);
    }
  }
  for (const auto& [slow, allowed] : kSlowHeaders) {
    for (const auto& file : found[slow]) EXPECT_TRUE(allowed.contains(file)) << file << " includes <" << slow << ">";
    for (const auto& file : allowed) EXPECT_TRUE(found[slow].contains(file)) << file << " need not be listed";
  }
}

/// Arguments of each call of a function in a CMake file, up to the first space.
std::multiset<std::string> calls_of(const std::string& function, const std::string& path, const char* then) {
  const auto text = read_text(root_folder() / path);
  const std::regex call("^" + function + R"re(\((\S+?)[ )])re" + then, std::regex::multiline);
  std::multiset<std::string> names;
  for (std::sregex_iterator it(text.begin(), text.end(), call), end; it != end; ++it) names.insert((*it)[1]);
  return names;
}

TEST(BuildCost, ThereAreAtMostTwelveBlocks) {
  auto blocks = calls_of("rubicon_block", "src/CMakeLists.txt", "");
  blocks.merge(calls_of("rubicon_block", "apps/CMakeLists.txt", ""));
  EXPECT_GE(blocks.size(), 8U);
  EXPECT_LE(blocks.size(), 12U);
}

TEST(BuildCost, EveryRoomIsPartOfABlock) {
  for (const auto* path : {"src/CMakeLists.txt", "src/networks/networks.cmake", "apps/CMakeLists.txt"}) {
    // A network of others may be a library of its own.
    for (const auto* function : {"rubicon_library", "rubicon_room", "rubicon_program_parts"}) {
      const auto all = calls_of(function, path, "");
      const auto in_blocks = calls_of(function, path, "[^\n]*BLOCK");
      for (const auto& room : all) {
        EXPECT_EQ(in_blocks.count(room), all.count(room)) << path << ": " << room << " has no BLOCK";
      }
    }
  }
}

TEST(BuildCost, RunBuildsWhatItStarts) {
  const auto run = read_text(root_folder() / "run");
  EXPECT_NE(run.find("\ndemo_targets=(rubicon-proxy rubicon-cli motes-simulator salad-simulator knx-simulator "
                     "zigbee-simulator)\n"),
            run.npos);
  EXPECT_NE(run.find("\nbuild demo \"${demo_targets[@]}\"\n"), run.npos);
}

}  // namespace
}  // namespace rubicon::structure
