#include "recorder/recorded_islands.h"

#include <gtest/gtest.h>

#include <ostream>

#include "config/yaml.h"
#include "island/network_types.h"
#include "model/point_keys.h"

namespace rubicon::recorder {

std::ostream& operator<<(std::ostream& out, const Seen& seen) {
  return out << '"' << seen.value << "\" (" << seen.media_type << ", measured "
             << seen.user_time.time_since_epoch().count() << ")";
}

TestIsland::TestIsland(const std::string& yaml, transport::MemoryTransports& disk, bool demand) {
  const auto tree = config::parse_yaml(yaml, "island.yaml");
  EXPECT_TRUE(tree) << tree.error().text;
  base::ConfigErrors errors;
  auto config = island::read_island_config(*tree, island::network_types(), errors);
  auto made = island::Island::make(std::move(config), time, disk, log, ecology, errors);
  EXPECT_TRUE(made) << errors.text();
  island = std::move(*made);
  ears_ = island->space().subscribe({island->config().id, "proxy.*.*.*.*.value"}, {{}, {}, 0, !demand},
                                    [this](const tuples::Event& event) {
                                      const auto& tuple = event.tuple;
                                      if (event.kind != tuples::EventKind::kSet || tuple.value.empty()) return;
                                      history_[std::string(tuple.key)].push_back(
                                          {std::string(tuple.value), std::string(tuple.media_type), tuple.user_time});
                                    });
  island->start();
  time.run_ready();
}

void TestIsland::command(const std::string& key, const std::string& value) {
  std::string answer = "none";
  island->space().set_remote(island->config().id, key, value, std::chrono::seconds(5), [&](const tuples::Reply& reply) {
    answer = std::string(to_string(reply.verdict)) + reply.text;
  });
  time.run_ready();
  EXPECT_EQ(answer, "applied") << key;
}

std::map<std::string, Seen> TestIsland::picture(const std::string& network) {
  std::map<std::string, Seen> all;
  for (const auto* pattern : {"proxy.*.*.*.*.value", "proxy.*.*.*.*.description", "proxy.*.*.description"}) {
    island->space().list({island->config().id, pattern}, [&](const tuples::TupleView& tuple) {
      if (!tuple.key.starts_with("proxy." + network + ".")) return;
      all[std::string(tuple.key)] = {std::string(tuple.value), std::string(tuple.media_type), tuple.user_time};
    });
  }
  // An event is over some time after it came: it is in the history, not in the picture.
  std::erase_if(all, [&](const auto& one) {
    const auto about = all.find(std::string(model::parent_key(one.first)) + ".description");
    return one.first.ends_with(".value") && about != all.end() &&
           about->second.value.find(R"("report":"event")") != std::string::npos;
  });
  return all;
}

}  // namespace rubicon::recorder
