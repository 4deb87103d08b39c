#include <cstdlib>

#include "base/bytes.h"
#include "bridges/ros2/graph.h"
#include "bridges/ros2/names.h"
#include "fuzz_target.h"
#include "rubicon/key.hpp"

namespace rubicon::fuzz::ros2_names_fuzz {

/// Input: a namespace, a newline, a key of a point; also a topic, a type and user data of others.
FUZZ_TARGET(ros2_names) {
  using namespace bridges::ros2;
  const auto text = base::as_text({data, size});
  const auto line_end = std::min(text.find('\n'), text.size());
  const auto first = text.substr(0, line_end), key = text.substr(std::min(line_end + 1, text.size()));
  if (!is_ros_name("/" + token(first).substr(0, kMaxName))) std::abort();
  if (model::check_key(key) && !is_ros_name(distinct_name(ros_name(first, key), key) + "/outcome")) std::abort();
  if (const auto topic = topic_of_dds(first)) {
    if (dds_topic(*topic) != first || !is_ros_name(*topic)) std::abort();
    const auto place = import_place(*topic);
    if (!model::check_key("p.ros2-r." + place.device + ".sensor.text-" + place.instance.substr(0, 64) + ".value"))
      std::abort();
  }
  if (const auto type = type_of_dds(first); type && type->find("/msg/") == type->npos) std::abort();
  std::ignore = user_datum(text, "enclave");
  return 0;
}

}  // namespace rubicon::fuzz::ros2_names_fuzz
