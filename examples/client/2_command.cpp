// Sets an actuator and prints the result: 2_command TYPE VALUE [NAME], for example `2_command lamp on`.
// Exit code 0: the device confirmed it, or cannot confirm; 3: the command was not executed; 4: no such actuator.
//
//   g++ -std=c++20 2_command.cpp $(pkg-config --cflags --libs rubicon) -o command

#include <algorithm>
#include <iostream>
#include <rubicon/client.hpp>

namespace {

/// The first actuator of the type: `lamp` finds `lamp-1`. Empty = none.
std::string actuator_of(const rubicon::client::Device& device, const std::string& type) {
  const auto& all = device.actuators;
  const auto found = std::find_if(all.begin(), all.end(), [&](const auto& one) { return one.starts_with(type + "-"); });
  return found == all.end() ? std::string() : *found;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::cerr << "usage: 2_command TYPE VALUE [NAME]\n";
    return 2;
  }
  auto opened = rubicon::Client::open();
  if (!opened) {
    std::cerr << opened.error().text << '\n';
    return 1;
  }
  rubicon::Client& client = **opened;

  rubicon::client::DeviceQuery query;
  query.type = argv[1];
  if (argc > 3) query.name = argv[3];
  for (const auto& device : client.devices(query)) {  // blocks, and runs the client's loop meanwhile
    const auto actuator = actuator_of(device, argv[1]);
    if (actuator.empty()) continue;
    const auto key = device.key() + ".actuator." + actuator + ".command";
    const auto outcome = client.command(device.island, key, argv[2]);
    std::cout << (device.name.empty() ? "" : device.name + ", ") << key << ": " << outcome.state;
    if (!outcome.reason.empty()) std::cout << " (" << outcome.reason << ')';
    std::cout << std::endl;
    return outcome.good() ? 0 : 3;
  }
  std::cerr << "no device has an actuator of type " << argv[1] << '\n';
  return 4;
}
