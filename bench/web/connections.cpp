#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <memory>

#include "web/generated_points.h"
#include "web/rig.h"
#include "web/web_client.h"

namespace rubicon::bench::web {

namespace {

using namespace std::chrono_literals;

using Clients = std::vector<std::unique_ptr<WebClient>>;

/// Reads from all of them for so long; gives the bytes of each.
std::vector<std::size_t> discard(const Clients& clients, Clock::duration span) {
  std::vector<std::size_t> bytes(clients.size());
  std::vector<pollfd> ready;
  for (const auto& client : clients) ready.push_back({client->descriptor(), POLLIN, 0});
  for (const auto until = Clock::now() + span; Clock::now() < until;) {
    ::poll(ready.data(), ready.size(), 50);
    for (std::size_t i = 0; i < ready.size(); ++i) {
      if (ready[i].revents != 0) bytes[i] += clients[i]->discard();
    }
  }
  return bytes;
}

double kilobytes_each(double grown_mb, int connections) {
  return rounded(grown_mb * 1e6 / 1024 / connections, 1);
}

}  // namespace

/// As many clients as the server accepts: memory without and with a subscription of all values, then the values.
void measure_connections(const Plan& plan, Json& out) {
  const Rig rig(out, "connections");
  if (!rig) return;
  auto island = rig.island(plan);
  Clients clients;
  clients.push_back(std::make_unique<WebClient>(island.port(), "/api/v1/ws"));
  const auto subscribe = [&](WebClient& client) {
    client.send_text(fmt::format(R"({{"id":1,"do":"subscribe","pattern":"{}"}})", kValues));
  };
  subscribe(*clients.front());
  discard(clients, 3s);
  const auto one = island.resident_mb();
  while (static_cast<int>(clients.size()) < plan.connections)
    clients.push_back(std::make_unique<WebClient>(island.port(), "/api/v1/ws"));
  discard(clients, 1s);
  const auto open = island.resident_mb();
  const auto more = plan.connections - 1;
  for (int i = 1; i < plan.connections; ++i) subscribe(*clients[static_cast<std::size_t>(i)]);
  discard(clients, 15s);
  const auto subscribed = island.resident_mb();
  island.set_rate(1'000);
  discard(clients, 2s);
  const auto before = island.processor();
  const auto began = Clock::now();
  const auto bytes = discard(clients, plan.watched);
  const auto seconds = seconds_since(began);
  out["connections"] = {
      {"open", clients.size()},
      {"kib_each", kilobytes_each(open - one, more)},
      {"kib_each_with_all_values", kilobytes_each(subscribed - open, more)},
      {"resident_mb", rounded(island.resident_mb(), 1)},
      {"cpu_percent", rounded((island.processor() - before) / seconds * 100, 1)},
      {"least_kb_per_second",
       rounded(static_cast<double>(*std::min_element(bytes.begin(), bytes.end())) / 1e3 / seconds, 1)},
      {"most_kb_per_second",
       rounded(static_cast<double>(*std::max_element(bytes.begin(), bytes.end())) / 1e3 / seconds, 1)}};
}

}  // namespace rubicon::bench::web
