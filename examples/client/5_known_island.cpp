// What a program does that knows its island: reads a value, commands an actuator, sends a message: 5_known_island
// [ISLAND [DEVICE]], for example `5_known_island 6541 living`. Exit code 3: the command was not executed.
//
//   g++ -std=c++20 5_known_island.cpp $(pkg-config --cflags --libs rubicon) -o known

#include <cstdlib>
#include <iostream>
#include <rubicon/client.hpp>
#include <rubicon/unit.hpp>

int main(int argc, char** argv) {
  // An id is a type of its own, so that a number is never taken for one by mistake: command(6541, ...) does not
  // compile.
  const rubicon::OwnerId island{static_cast<std::uint32_t>(argc > 1 ? std::atoi(argv[1]) : 6541)};
  const std::string device = "proxy.dummy-rooms." + std::string(argc > 2 ? argv[2] : "living");
  auto opened = rubicon::Client::open();
  if (!opened) {
    std::cerr << opened.error().text << '\n';
    return 1;
  }
  rubicon::Client& client = **opened;

  // std::vector<Tuple>: whatever is below the device, as it is now. Creates no demand.
  for (const rubicon::client::Tuple& tuple : client.read({island, device + ".**"}))
    std::cout << tuple.key << " = " << tuple.value << '\n';

  // Result<std::vector<Point>>: values with quality and unit.
  if (const auto points = client.read_points({island, device + ".sensor.*"})) {
    for (const rubicon::client::Point& point : *points)
      std::cout << point.key() << ": " << point.value() << ' ' << rubicon::unit_text(point.unit) << ' '
                << point.status.quality << '\n';
  }

  // Outcome: the value is a text in the unit of the point; the time to live and the wait are durations.
  const rubicon::client::Outcome outcome = client.command(island, device + ".actuator.lamp-1.command", "on",
                                                          std::chrono::seconds(2), std::chrono::seconds(10));
  std::cout << "lamp-1: " << outcome.state << (outcome.reason.empty() ? "" : ": " + outcome.reason) << '\n';

  // The type is a word of your own, the content any bytes; the reply comes by the loop.
  bool heard = false;
  client.send(island, "chat", "hello", [&heard](const std::string& why_not) {
    std::cout << "message: " << (why_not.empty() ? "taken" : why_not) << '\n';
    heard = true;
  });
  client.run_until([&heard] { return heard; }, std::chrono::seconds(10));
  return outcome.good() ? 0 : 3;
}
