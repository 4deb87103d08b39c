#include "network-template/template_network.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "rubicon/key.hpp"
// The build makes this header from sample.yaml.
#include "networks/template/template_sample.h"

namespace rubicon::networks::template_network {

namespace {

using model::PointId;

/// What the configuration says, checked.
struct Options {
  std::string device;
  double temperature = 0;
};

/// One device with a thermometer and a lamp. A real network would talk to it through a line of host.transports().
class TemplateNetwork final : public network::Network {
 public:
  TemplateNetwork(const network::NetworkConfig& config, Options options, network::NetworkHost& host)
      : options_(std::move(options)),
        host_(host),
        thermometer_{Kind::kSensor, config.types.find("temperature")->id, "1"},
        lamp_{Kind::kActuator, config.types.find("switch")->id, "1"} {}

  // Called at the start and again after each host_.failed(why). Must not block: begin to connect, and deliver
  // State{kUp} when the line works. Here there is nothing to connect.
  Result<void> open() override {
    host_.deliver({}, model::State{model::LineState::kUp, {}, {}});
    model::Join join;
    join.name = "Template lamp";
    join.capabilities.resize(2);
    join.capabilities[0].point = thermometer_;
    join.capabilities[1].point = lamp_;
    join.capabilities[1].access = model::Access::kReadWrite;
    host_.deliver(options_.device, std::move(join));
    return {};
  }

  // Called for every message to a device of this network. Returns an error, or delivers an Acknowledge later.
  Result<void> send(const Message& message) override {
    if (message.destination.device != options_.device)
      return fail(ErrorCode::kNotFound, fmt::format("no device {}", model::quoted(message.destination.device)));
    if (const auto* sample = std::get_if<model::Sample>(&message.body)) return this->sample(*sample);
    if (const auto* actuate = std::get_if<model::Actuate>(&message.body)) return this->actuate(*actuate);
    return fail(ErrorCode::kUnsupported, fmt::format("the lamp takes no {}", to_string(message.kind())));
  }

 private:
  // Sample these sensors, at this period, and no others. An empty list means that no subscriber is left.
  Result<void> sample(const model::Sample& sample) {
    for (const PointId& point : sample.points) {
      if (point != thermometer_) return fail(ErrorCode::kNotFound, "the lamp has only a temperature-1");
    }
    timer_.cancel();
    host_.deliver(options_.device, model::Acknowledge{sample.request, model::Outcome::kSent, {}});
    if (!sample.points.empty()) measure(std::max<Duration>(sample.period, std::chrono::milliseconds(100)));
    return {};
  }

  // Time comes from the scheduler, so that tests run in virtual time. The timer ends with the network.
  void measure(Duration period) {
    report(thermometer_, options_.temperature);
    timer_ = host_.scheduler().after(period, [this, period] { measure(period); });
  }

  // The acknowledgement means that the command was sent; only the report of the device confirms it.
  Result<void> actuate(const model::Actuate& actuate) {
    if (actuate.point != lamp_) return fail(ErrorCode::kNotFound, "the lamp has only a switch-1");
    host_.deliver(options_.device, model::Acknowledge{actuate.request, model::Outcome::kSent, {}});
    report(lamp_, actuate.value);
    return {};
  }

  void report(const PointId& point, Value value) {
    host_.deliver(options_.device, model::Updates{{{point, std::move(value), host_.scheduler().wall_now()}}});
  }

  Options options_;
  network::NetworkHost& host_;
  PointId thermometer_, lamp_;
  Timer timer_;
};

// Reads every option; reports what is wrong by options.error with file, line and column. Opens nothing.
Options read_template_options(const network::NetworkConfig& config) {
  Options options;
  options.device = config.options.required_text("device");
  options.temperature = config.options.real("temperature", 20, -50, 100);
  return options;
}

}  // namespace

// network.h describes the other fields, such as how often a lost line is opened again.
const network::NetworkType kType{
    .name = "template",
    .summary = "an example to copy: one lamp with a thermometer",
    .sample_config = kSample,
    .make = network::make_network<TemplateNetwork, read_template_options>,
};

}  // namespace rubicon::networks::template_network
