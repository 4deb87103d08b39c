// Measures bridges/ros2: rubicon-bench-ros2 prints one JSON object (bench/README.md, "ROS 2 bridge").
#include "frame/program.h"
#include "ros2/measurements.h"

int main(int argc, char** argv) {
  using namespace rubicon::bench::ros2;
  using namespace std::chrono_literals;
  const Plan quick{20, 200, 1s, 2s};
  return rubicon::bench::run_program(
      argc, argv, {"rubicon-bench-ros2", "Measures the ROS 2 bridge beside bare DDS"}, quick,
      {{"topics", measure_topics}, {"latency", measure_latency}, {"flood", measure_flood}, {"idle", measure_idle}});
}
