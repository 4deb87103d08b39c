// Prints the values of all sensors of a type, on all islands, as they arrive: 1_watch [TYPE]. Ctrl-C ends it.
//
//   g++ -std=c++20 1_watch.cpp $(pkg-config --cflags --libs rubicon) -o watch

#include <csignal>
#include <iostream>
#include <map>
#include <rubicon/client.hpp>

namespace {

rubicon::Client* running = nullptr;

void end(int) {
  running->stop();  // may be called from a signal handler
}

void print(const rubicon::Event& event) {
  const auto& tuple = event.tuple;
  std::cout << number(tuple.owner) << ':' << tuple.key << ' ';
  if (event.kind == rubicon::EventKind::kSet) {
    std::cout << tuple.value << std::endl;
  } else {
    std::cout << '(' << to_string(event.kind) << ')' << std::endl;
  }
}

/// Subscribes to the device's sensors of the type. The subscription creates demand: the sensors are sampled.
std::vector<rubicon::Handle> subscriptions(rubicon::Client& client, const rubicon::client::Device& device,
                                           const std::string& type) {
  rubicon::Flow flow;
  flow.minimum = std::chrono::milliseconds(500);  // at most two values per second
  std::vector<rubicon::Handle> all;
  for (const auto& sensor : device.sensors) {
    if (!sensor.starts_with(type + "-")) continue;
    const rubicon::Pattern value{device.island, device.key() + ".sensor." + sensor + ".value"};
    all.push_back(client.tuples().subscribe(value, flow, print));
  }
  return all;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string type = argc > 1 ? argv[1] : "temperature";
  rubicon::client::Options options;
  options.name = "example watch";
  options.warn = [](std::string_view text) { std::cerr << text << '\n'; };
  auto client = rubicon::Client::open(options);
  if (!client) {
    std::cerr << client.error().text << '\n';
    return 1;
  }
  running = client->get();
  std::signal(SIGINT, end);
  std::signal(SIGTERM, end);

  std::map<std::pair<rubicon::OwnerId, std::string>, std::vector<rubicon::Handle>> watched;
  rubicon::client::DeviceQuery query;
  query.type = type;
  // Called for the devices that are present and for those that appear later, on any island.
  const auto devices = (*client)->watch_devices(query, [&](const rubicon::client::Device& device, bool present) {
    auto& handles = watched[{device.island, device.key()}];
    handles.clear();  // ends the subscriptions: the device is gone, or its sensors changed
    if (present) handles = subscriptions(**client, device, type);
  });
  (*client)->run();
}
