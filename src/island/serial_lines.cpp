#include "island/serial_lines.h"

#include <fmt/format.h>

#include <filesystem>
#include <map>

#include "networks/wsn/sink/source.h"

namespace rubicon::island {

namespace {

using networks::wsn::sink::Source;

/// The device of a network whose `source` is a serial line, whatever link leads there; empty = it has none.
std::string serial_device(const ConfigNode& source) {
  const auto read = networks::wsn::sink::parse_source(source.text);
  if (!read || read->kind != Source::Kind::kSerial) return {};
  std::error_code unknown;
  const auto device = std::filesystem::weakly_canonical(read->path, unknown);
  return unknown ? read->path : device.string();
}

}  // namespace

void check_serial_lines(const IslandConfig& config, base::ConfigErrors& errors) {
  struct User {
    std::string network;
    ConfigPlace place;
  };
  std::map<std::string, User> users;
  for (const auto& setup : config.networks) {
    const auto* source = setup.options.find("source");
    const auto device = source == nullptr ? std::string() : serial_device(*source);
    if (device.empty()) continue;
    const auto [first, fresh] = users.try_emplace(device, User{setup.key, source->place});
    if (fresh) continue;
    errors.add(source->place, fmt::format("networks.{}.source", setup.key),
               fmt::format("{} is the serial line of network {} too ({}), expected a device of its own", device,
                           first->second.network, to_string(first->second.place)));
  }
}

}  // namespace rubicon::island
