#include <gtest/gtest.h>

#include <map>
#include <regex>
#include <set>

#include "structure/tree.h"

namespace rubicon::structure {
namespace {

using Names = std::set<std::string>;

/// What each folder may include besides base, model and itself (docs/architecture.md, section 2).
const std::map<std::string, Names> kFolderEdges{
    {"base", {}},
    {"model", {}},
    {"transport", {}},
    {"tuples", {}},
    {"tuples/dds", {"transport"}},
    {"tuples/host", {"transport"}},
    {"tuples/mqtt", {"transport"}},
    {"tuples/peis", {"transport"}},
    {"tuples/engines", {"transport"}},
    {"rights", {"tuples"}},
    {"verbs", {"tuples"}},
    {"trust", {"tuples"}},
    {"network", {"transport"}},
    {"motes", {}},
    {"recording", {}},
    {"networks/log", {"motes", "recording"}},
    {"networks/wsn", {"motes"}},
    {"gateway", {"network", "tuples"}},
    {"client", {"transport", "tuples", "gateway", "trust"}},
    {"sqlite", {}},
    {"state", {"sqlite"}},
    {"proxy", {"gateway", "tuples", "state"}},
    {"config", {"recording", "rights", "transport", "tuples"}},
    {"recorder", {"config", "recording", "transport", "tuples"}},
    {"history", {"config", "recording", "sqlite", "transport", "tuples", "gateway"}},
    {"console", {"client", "transport", "tuples", "verbs"}},
    {"island",
     {"config", "recorder", "transport", "tuples", "network", "networks", "gateway", "state", "proxy", "rights"}},
    {"bridges", {"client", "transport", "tuples"}},
    {"web", {"client", "history", "config", "transport", "tuples", "gateway", "verbs"}},
    {"apps/program", {}},
    {"apps/rubicon",
     {"apps/program", "client", "config", "recorder", "recording", "sqlite", "networks/knx", "networks/zigbee",
      "transport", "tuples", "network", "gateway", "history", "web", "rights", "trust", "bridges"}},
    {"apps/rubicon-proxy",
     {"apps/program", "island", "console", "config", "recorder", "recording", "state", "transport", "tuples", "network",
      "networks/knx", "gateway", "proxy", "history", "web", "rights", "trust", "bridges"}},
    {"apps/simulators", {"apps/program", "config", "networks/salad", "networks/knx", "network", "motes", "transport"}},
};

/// The folder that each public header is part of.
const std::map<std::string, std::string> kPublicHeaders{
    {"rubicon/address.hpp", "model"}, {"rubicon/client.hpp", "client"}, {"rubicon/key.hpp", "model"},
    {"rubicon/point.hpp", "model"},   {"rubicon/result.hpp", "base"},   {"rubicon/summary.hpp", "model"},
    {"rubicon/time.hpp", "base"},     {"rubicon/tuple.hpp", "tuples"},  {"rubicon/tuple_space.hpp", "tuples"},
    {"rubicon/unit.hpp", "model"},
};

/// What every network may include besides.
const Names kNetworkEdges{"network", "transport"};

/// Third-party headers, by their beginning, and the folders that may use them.
const std::map<std::string, Names> kLibraryEdges{
    {"tl/", {"base"}},
    {"dds/", {"tuples/dds", "bridges/ros2"}},
    {"boost/", {"transport", "console", "web", "apps/rubicon-proxy"}},
    {"yaml-cpp/", {"config"}},
    {"spdlog/", {"apps/program"}},
    {"CLI/", {"apps/program", "apps/rubicon", "apps/rubicon-proxy", "apps/simulators"}},
    {"nlohmann/", {"model",           "tuples",       "trust",        "network",         "recording",
                   "networks/log",    "networks/knx", "networks/wsn", "networks/zigbee", "state",
                   "proxy",           "client",       "config",       "console",         "history",
                   "bridges",         "island",       "web",          "apps/rubicon",    "apps/rubicon-proxy",
                   "apps/simulators", "verbs"}},
    {"sqlite3.h", {"sqlite"}},
    {"zstd.h", {"recording", "history", "tuples/mqtt"}},
    {"mosquitto.h", {"transport"}},
    {"mqtt_protocol.h", {"transport"}},
    {"openssl/", {"transport", "trust", "web", "networks/knx/secure"}},
    {"zip.h", {"networks/knx/project"}},
    {"expat.h", {"networks/knx"}},
    {"simdjson.h", {"networks/zigbee"}},
    {"thread", {"transport", "tuples/dds"}},
    {"mutex", {"transport", "tuples/dds", "bridges/ros2"}},
    {"condition_variable", {"transport"}},
    {"future", {"transport"}},
};

/// `src/networks/log/x.cpp` -> `networks/log`, `include/rubicon/key.hpp` -> `model`, `apps/rubicon/x.cpp` ->
/// `apps/rubicon`.
std::string folder_of(const std::string& path) {
  const auto inner = path.starts_with("src/") ? path.substr(4) : path.starts_with("include/") ? path.substr(8) : path;
  if (const auto known = kPublicHeaders.find(inner); known != kPublicHeaders.end()) return known->second;
  const auto first = inner.substr(0, inner.find('/'));
  if (first != "networks" && first != "apps") return first;
  const auto rest = inner.substr(first.size() + 1);
  return first + "/" + rest.substr(0, rest.find('/'));
}

/// Folders below another that may use more than that: Cyclone DDS, which has threads; PEIS, the folder of a host
/// and brokers, which have sockets; what opens engines; KNX Secure, which has keys;
/// KNX projects, which are archives.
const Names kRooms{"tuples/dds",     "tuples/host",          "tuples/mqtt",         "tuples/peis",
                   "tuples/engines", "networks/knx/project", "networks/knx/secure", "bridges/ros2"};

std::string room_of(const std::string& path, const std::string& folder) {
  for (const auto& room : kRooms) {
    if (path.starts_with("src/" + room + "/")) return room;
  }
  return folder;
}

bool library_allowed(const std::string& header, const std::string& folder) {
  for (const auto& [prefix, folders] : kLibraryEdges) {
    const bool whole = prefix.find('/') == prefix.npos;
    if (whole ? header == prefix : header.starts_with(prefix)) return folders.contains(folder);
  }
  return true;
}

bool folder_allowed(const std::string& target, const std::string& folder) {
  if (target == folder) return true;
  if (target == "wire.h") return folder == "tuples";  // what idlc writes of tuples/dds/wire.idl
  if (target == "ros_types.h") return folder == "bridges/ros2";
  if (folder != "base" && target == "base") return true;
  if (folder != "base" && target == "model") return true;
  if (folder.starts_with("networks/") && kNetworkEdges.contains(target)) return true;
  const auto edges = kFolderEdges.find(folder);
  if (edges == kFolderEdges.end()) return false;
  return edges->second.contains(target) || edges->second.contains(target.substr(0, target.find('/')));
}

std::vector<std::string> forbidden_edges(const SourceFile& file) {
  static const std::regex kInclude(R"re(^[ \t]*#[ \t]*include[ \t]*([<"])([^>"]+)[>"])re", std::regex::multiline);
  std::vector<std::string> found;
  const auto folder = folder_of(file.path);
  const auto room = room_of(file.path, folder);
  for (std::sregex_iterator it(file.text.begin(), file.text.end(), kInclude), end; it != end; ++it) {
    const auto header = (*it)[2].str();
    if ((*it)[1] == "<") {
      if (!library_allowed(header, folder) && !library_allowed(header, room))
        found.push_back(file.path + " includes <" + header + ">");
    } else if (!header.ends_with("_sample.h") && !folder_allowed(folder_of(header), folder) &&
               !folder_allowed(folder_of(header), room)) {
      found.push_back(file.path + " includes " + header);
    }
  }
  return found;
}

TEST(IncludeEdges, EveryIncludeFollowsTheLayers) {
  auto files = files_below("src", {".h", ".cpp"});
  for (auto& file : files_below("apps", {".h", ".cpp"})) files.push_back(std::move(file));
  for (auto& file : files_below("include", {".hpp"})) files.push_back(std::move(file));
  ASSERT_GT(files.size(), 50U);
  for (const auto& file : files) {
    const auto folder = folder_of(file.path);
    EXPECT_TRUE(kFolderEdges.contains(folder) || folder.starts_with("networks/"))
        << file.path << " lies in a folder that kFolderEdges does not name";
    for (const auto& edge : forbidden_edges(file)) ADD_FAILURE() << edge;
  }
}

TEST(IncludeEdges, AForbiddenEdgeIsFound) {
  EXPECT_EQ(forbidden_edges({"src/tuples/store.cpp", "#include \"proxy/proxy.h\"\n"}).size(), 1U);
  EXPECT_EQ(forbidden_edges({"src/base/bytes.cpp", "#include \"rubicon/key.hpp\"\n"}).size(), 1U);
  EXPECT_EQ(forbidden_edges({"src/model/key.cpp", "#include \"rubicon/tuple.hpp\"\n"}).size(), 1U);
  EXPECT_EQ(forbidden_edges({"include/rubicon/summary.hpp", "#include \"rubicon/tuple.hpp\"\n"}).size(), 1U);
  EXPECT_EQ(forbidden_edges({"src/networks/dummy/wave.cpp", "#include \"networks/log/file_chain.h\"\n"}).size(), 1U);
  EXPECT_EQ(forbidden_edges({"src/networks/dummy/wave.cpp", "#include \"motes/mote_codec.h\"\n"}).size(), 1U);
  EXPECT_EQ(forbidden_edges({"src/proxy/demand.cpp", "#include <thread>\n"}).size(), 1U);
  EXPECT_EQ(forbidden_edges({"src/networks/zigbee/device.cpp", "#include <mosquitto.h>\n"}).size(), 1U);
  EXPECT_EQ(forbidden_edges({"src/networks/knx/line/line.cpp", "#include <openssl/evp.h>\n"}).size(), 1U);
  EXPECT_EQ(forbidden_edges({"src/gateway/gateway.cpp", "# include <boost/asio/io_context.hpp>\n"}).size(), 1U);
}

TEST(IncludeEdges, AnAllowedEdgeIsNotFound) {
  EXPECT_TRUE(forbidden_edges({"src/tuples/dds/reader_stores.h", "#include <mutex>\n"}).empty());
  EXPECT_EQ(forbidden_edges({"src/tuples/store.h", "#include <mutex>\n"}).size(), 1U);
  EXPECT_TRUE(forbidden_edges({"src/networks/knx/secure/crypto.cpp", "#include <openssl/evp.h>\n"}).empty());
  EXPECT_TRUE(
      forbidden_edges({"src/networks/log/log.cpp", "#include \"motes/mote_codec.h\"\n#include <vector>\n"}).empty());
  EXPECT_TRUE(
      forbidden_edges({"src/proxy/demand.cpp", "#include \"gateway/gateway.h\"\n#include \"rubicon/time.hpp\"\n"})
          .empty());
}

}  // namespace
}  // namespace rubicon::structure
