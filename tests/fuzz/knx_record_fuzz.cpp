#include <cstddef>
#include <cstdint>
#include <string_view>

#include "config/yaml.h"
#include "fuzz_target.h"
#include "networks/knx/groups/group_file.h"
#include "networks/knx/groups/import.h"

namespace rubicon::fuzz::knx_record_fuzz {

namespace {

using namespace rubicon::networks::knx::groups;
using namespace rubicon::networks::knx::wire;

struct Record {
  std::vector<GroupPoint> points;
  std::vector<GroupAddress> secured;
};

Record record_of(const ConfigNode& root, base::ConfigErrors& errors) {
  Record record;
  base::ConfigReader reader(root, "", errors);
  read_groups(reader, record.points);
  record.secured = read_secured_groups(reader);
  return record;
}

}  // namespace

/// A record. What was taken of it has no conflicts, and is the same again from the text that we write of it.
FUZZ_TARGET(knx_record) {
  if (size > 65536) return 0;
  const auto root = config::parse_yaml({reinterpret_cast<const char*>(data), size}, "fuzz.yaml");
  if (!root) return 0;
  base::ConfigErrors errors;
  const auto record = record_of(*root, errors);
  if (!conflicts(record.points).empty()) __builtin_trap();
  const auto text = to_yaml(record.points, "fuzz.yaml", record.secured);
  const auto again = config::parse_yaml(text, "again.yaml");
  if (!again) __builtin_trap();
  base::ConfigErrors none;
  const auto same = record_of(*again, none);
  if (!none.empty() || same.points.size() != record.points.size()) __builtin_trap();
  if (to_yaml(same.points, "fuzz.yaml", same.secured) != text) __builtin_trap();
  return 0;
}

}  // namespace rubicon::fuzz::knx_record_fuzz
