#include "native/options.h"

#include <pybind11/stl.h>

#include <chrono>
#include <vector>

namespace rubicon::python {

namespace {

using Texts = std::vector<std::string>;

Duration duration(double seconds) {
  return std::chrono::duration_cast<Duration>(std::chrono::duration<double>(seconds));
}

Texts texts(const py::dict& options, const char* name) {
  return options.contains(name) ? options[name].cast<Texts>() : Texts{};
}

client::Broker broker_of(const py::dict& options) {
  client::Broker broker;
  broker.host = text(options, "host");
  broker.spare = texts(options, "spare");
  if (options.contains("port")) broker.port = options["port"].cast<std::uint16_t>();
  broker.space = text(options, "space", "default");
  broker.user = text(options, "user");
  broker.password = text(options, "password");
  broker.tls = flag(options, "tls");
  broker.ca_file = text(options, "ca_file");
  broker.certificate_file = text(options, "certificate_file");
  broker.key_file = text(options, "key_file");
  broker.server_name = text(options, "server_name");
  broker.all = flag(options, "all");
  broker.trust = flag(options, "trust");
  return broker;
}

}  // namespace

void raise(const Error& error) {
  const auto type = py::module_::import("rubicon").attr("Error");
  PyErr_SetObject(type.ptr(), type(std::string(base::to_string(error.code)), error.text).ptr());
  throw py::error_already_set();
}

std::string text(const py::dict& options, const char* name, const char* otherwise) {
  return options.contains(name) ? options[name].cast<std::string>() : otherwise;
}

double seconds(const py::dict& options, const char* name) {
  return options.contains(name) ? options[name].cast<double>() : 0;
}

bool flag(const py::dict& options, const char* name) {
  return options.contains(name) && options[name].cast<bool>();
}

WallTime wall_time(double seconds) {
  return WallTime(std::chrono::duration_cast<std::chrono::microseconds>(std::chrono::duration<double>(seconds)));
}

client::Options options_of(const py::dict& options) {
  client::Options made;
  made.name = text(options, "name");
  made.id = OwnerId{options.contains("id") ? options["id"].cast<std::uint32_t>() : 0};
  made.folder = text(options, "folder");
  made.space = text(options, "space");
  made.interfaces = texts(options, "interfaces");
  if (options.contains("broker")) made.broker = broker_of(options["broker"]);
  if (options.contains("warn"))
    made.warn = [warn = options["warn"].cast<py::function>()](std::string_view line) {
      try {
        warn(std::string(line));
      } catch (py::error_already_set& error) {
        error.discard_as_unraisable(warn);
      }
    };
  return made;
}

Flow flow_of(const py::dict& flow) {
  Flow made;
  made.minimum = duration(seconds(flow, "minimum"));
  made.maximum = duration(seconds(flow, "maximum"));
  made.dead_band = seconds(flow, "dead_band");
  made.passive = flag(flow, "passive");
  return made;
}

}  // namespace rubicon::python
