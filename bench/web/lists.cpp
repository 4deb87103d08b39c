#include <fmt/format.h>

#include <stdexcept>

#include "web/generated_points.h"
#include "web/rig.h"
#include "web/watched_values.h"

namespace rubicon::bench::web {

namespace {

/// All pages of the list of devices; gives how many there are.
std::size_t list_devices(int port, std::size_t& bytes) {
  std::size_t devices = 0;
  std::string target = "/api/v1/devices?limit=1000";
  while (!target.empty()) {
    const auto text = http_get(port, target);
    bytes += text.size();
    const auto page = nlohmann::json::parse(text);
    devices += page.at("devices").size();
    target = page.value("next", std::string());
  }
  return devices;
}

}  // namespace

/// All devices by REST, one page after the other.
void measure_devices(const Plan& plan, Json& out) {
  const Rig rig(out, "devices");
  if (!rig) return;
  const auto island = rig.island(plan);
  std::vector<double> times, processor;
  std::size_t bytes = 0;
  for (int i = 0; i < plan.rounds; ++i) {
    bytes = 0;
    const auto before = island.processor();
    const auto began = Clock::now();
    if (list_devices(island.port(), bytes) != static_cast<std::size_t>(plan.devices))
      throw std::runtime_error("the list lacks devices");
    times.push_back(milliseconds(Clock::now() - began));
    processor.push_back((island.processor() - before) * 1000);
  }
  out["devices"] = {{"devices", plan.devices},
                    {"first_ms", rounded(times.front(), 0)},
                    {"ms", rounded(median(times), 0)},
                    {"processor_ms", rounded(median(processor), 0)},
                    {"mb", rounded(static_cast<double>(bytes) / 1e6, 2)}};
}

/// All values by WebSocket.
void measure_values(const Plan& plan, Json& out) {
  const Rig rig(out, "values");
  if (!rig) return;
  const auto island = rig.island(plan);
  std::vector<double> times;
  std::size_t bytes = 0;
  for (int i = 0; i < plan.rounds; ++i) {
    const auto began = Clock::now();
    const PageClient client(island.port(), plan.devices);
    times.push_back(milliseconds(Clock::now() - began));
    bytes = client.seen.bytes;
  }
  out["values"] = {{"points", plan.devices * kPointsPerDevice},
                   {"ms", rounded(median(times), 0)},
                   {"mb", rounded(static_cast<double>(bytes) / 1e6, 2)}};
}

}  // namespace rubicon::bench::web
