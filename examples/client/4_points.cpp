// Prints the points of a type with their quality, then each change: 4_points [TYPE]. Ctrl-C ends it.
//
//   g++ -std=c++20 4_points.cpp $(pkg-config --cflags --libs rubicon) -o points

#include <csignal>
#include <iostream>
#include <rubicon/client.hpp>
#include <rubicon/unit.hpp>

namespace {

using rubicon::client::Point;
using rubicon::client::PointEvent;

rubicon::Client* running = nullptr;

void end(int) {
  running->stop();
}

void print(PointEvent event, const Point& point) {
  std::cout << point.key() << ' ';
  if (event == PointEvent::kRemoved) {
    std::cout << "(gone)" << std::endl;
    return;
  }
  std::cout << point.value() << ' ' << rubicon::unit_text(point.unit);  // °C of the code Cel
  if (!point.good()) std::cout << " [" << point.status.quality << ": " << point.status.reason << ']';
  if (!point.line.works()) std::cout << " [line " << point.line.line << ": " << point.line.reason << ']';
  std::cout << std::endl;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string type = argc > 1 ? argv[1] : "temperature";
  auto client = rubicon::Client::open();
  if (!client) {
    std::cerr << client.error().text << '\n';
    return 1;
  }
  running = client->get();
  std::signal(SIGINT, end);
  std::signal(SIGTERM, end);

  // The first instance of the type in each device, on any network of any island.
  const rubicon::Pattern points{std::nullopt, "*.*.*.sensor." + type + "-1"};
  rubicon::Flow flow;
  flow.passive = true;  // without it the sensors would be sampled for as long as this runs
  const auto watch = (*client)->watch_points(points, flow, print);
  if (!watch) {
    std::cerr << watch.error().text << '\n';
    return 2;
  }
  (*client)->run();
}
