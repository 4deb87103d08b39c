#include <cstddef>
#include <cstdint>
#include <string_view>

#include "config/yaml.h"
#include "networks/knx/groups/group_file.h"

namespace {

using namespace rubicon;
using namespace rubicon::networks::knx::groups;
using namespace rubicon::networks::knx::wire;

std::vector<GroupPoint> points_of(const ConfigNode& root, base::ConfigErrors& errors) {
  std::vector<GroupPoint> points;
  base::ConfigReader reader(root, "", errors);
  read_groups(reader, points);
  return points;
}

}  // namespace

/// A record. What was taken of it has no conflicts, and is the same again from the text that we write of it.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  if (size > 65536) return 0;
  const auto root = config::parse_yaml({reinterpret_cast<const char*>(bytes), size}, "fuzz.yaml");
  if (!root) return 0;
  base::ConfigErrors errors;
  const auto points = points_of(*root, errors);
  if (!conflicts(points).empty()) __builtin_trap();
  const auto text = to_yaml(points, "fuzz.yaml");
  const auto again = config::parse_yaml(text, "again.yaml");
  if (!again) __builtin_trap();
  base::ConfigErrors none;
  const auto same = points_of(*again, none);
  if (!none.empty() || same.size() != points.size() || to_yaml(same, "fuzz.yaml") != text) __builtin_trap();
  return 0;
}
