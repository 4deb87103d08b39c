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

/// All devices by REST, one page after the other, and all values by WebSocket; times and processor time of the server.
void measure_lists(const Plan& plan, Json& out) {
  const Rig rig(out, "lists");
  if (!rig) return;
  auto island = rig.island(plan);
  std::vector<double> rest, processor, snapshot;
  std::size_t bytes = 0;
  for (int i = 0; i < plan.rounds; ++i) {
    bytes = 0;
    const auto before = island.processor();
    const auto began = Clock::now();
    if (list_devices(island.port(), bytes) != static_cast<std::size_t>(plan.devices))
      throw std::runtime_error("the list lacks devices");
    rest.push_back(milliseconds(Clock::now() - began));
    processor.push_back((island.processor() - before) * 1000);
  }
  std::size_t snapshot_bytes = 0;
  for (int i = 0; i < plan.rounds; ++i) {
    const auto began = Clock::now();
    const PageClient client(island.port(), plan.devices);
    snapshot.push_back(milliseconds(Clock::now() - began));
    snapshot_bytes = client.seen.bytes;
  }
  out["lists"] = {{"devices", plan.devices},
                  {"points", plan.devices * kPointsPerDevice},
                  {"rest_first_ms", rounded(rest.front(), 0)},
                  {"rest_ms", rounded(median(rest), 0)},
                  {"rest_processor_ms", rounded(median(processor), 0)},
                  {"rest_mb", rounded(static_cast<double>(bytes) / 1e6, 2)},
                  {"values_ms", rounded(median(snapshot), 0)},
                  {"values_mb", rounded(static_cast<double>(snapshot_bytes) / 1e6, 2)}};
}

}  // namespace rubicon::bench::web
