#include "apps/rubicon/zigbee/tool.h"

#include <fmt/format.h>

#include "apps/rubicon/output/tuple_text.h"
#include "model/json_members.h"

namespace rubicon::cli::zigbee {

namespace {

using nlohmann::json;

/// Zigbee2MQTT permits no longer time.
constexpr std::chrono::seconds kMaxTime{254};
/// This number of signals ends the program before Zigbee2MQTT confirms that joining is closed.
constexpr int kMaxInterrupts = 3;

struct PermitOptions {
  std::string time, via;
};

std::string what_happened(const std::string& event) {
  if (event == "joined") return "joined";
  if (event == "interviewing") return "is being interviewed";
  if (event == "interviewed") return "is ready";
  if (event == "failed") return "could not be interviewed";
  if (event == "announced") return "is back";
  if (event == "left") return "left";
  return event;
}

std::string event_line(const json& event) {
  const auto model = fmt::format("{}{}{}", model::text_of(event, "vendor"), event.contains("vendor") ? " " : "",
                                 model::text_of(event, "model"));
  const auto why = model::text_of(event, "why");
  return fmt::format("{}  {} {}{}{}{}{}", model::text_of(event, "address"), model::text_of(event, "name"),
                     what_happened(model::text_of(event, "event")), model.empty() ? "" : ": ", model,
                     why.empty() ? "" : "; ", why);
}

}  // namespace

int watch_joins(Tool& tool, const std::string& id) {
  bool closed = false;
  std::string why;
  std::size_t ready = 0;
  auto& line = tool.line();
  line.on_event = [&](const json& event) {
    if (model::text_of(event, "id") != id) return;
    const auto what = model::text_of(event, "event");
    if (tool.json()) tool.print_json(event);
    if (what == "interviewed") ++ready;
    if (what != "closed") {
      if (!tool.json()) tool.out().line(printable(event_line(event)));
      return;
    }
    closed = true;
    why = model::text_of(event, "why");
  };
  const auto is_closed = [&] { return closed; };
  if (!line.run(is_closed, kMaxTime + kPatience)) line.send({{"do", "permit"}, {"seconds", 0}});
  // One interrupt may come as two signals: to the program and to its group.
  for (int i = 0; i < kMaxInterrupts && !closed && !tool.out().broken(); ++i) {
    line.resume();
    line.run(is_closed, kPatience);
  }
  line.on_event = {};
  if (!why.empty()) {
    print_error(printable(why));
    return kNotDone;
  }
  if (!closed) {
    print_error("Zigbee2MQTT did not confirm that joining is closed");
    return kNotDone;
  }
  if (!tool.json()) tool.out().line(fmt::format("joining is closed; {} ready", counted(ready, "new device")));
  return kGood;
}

namespace {

int permit(Tool& tool, const PermitOptions& options) {
  const auto time = std::chrono::ceil<std::chrono::seconds>(parse_duration_or(options.time, std::chrono::seconds(60)));
  if (time > kMaxTime) {
    print_error(fmt::format("--for is {}, expected at most {} s", options.time, kMaxTime.count()));
    return kUsage;
  }
  json request{{"do", "permit"}, {"seconds", time.count()}};
  if (const int code = options.via.empty() ? kGood : tool.name_device(request, "via", options.via); code != kGood)
    return code;
  const auto reply = tool.line().reply_to(std::move(request), kPatience);
  if (!model::flag_of(reply, "ok")) return refused(reply);
  if (time.count() == 0) {
    if (!tool.json()) tool.out().line("joining is closed");
    return kGood;
  }
  if (!tool.json())
    tool.out().line(fmt::format("devices may join for {} s{}; Ctrl-C ends that", time.count(),
                                options.via.empty() ? "" : " through " + printable(options.via)));
  tool.out().flush();
  return watch_joins(tool, model::text_of(reply, "id"));
}

}  // namespace

void add_permit(Cli& cli, CLI::App* parent) {
  const auto options = std::make_shared<PermitOptions>();
  auto* app = Tool::add(cli, parent,
                        {"permit", "Let devices join, and show them until joining is closed",
                         "  rubicon zigbee permit\n"
                         "  rubicon zigbee permit --for 2min --via living/ceiling\n"
                         "  rubicon zigbee permit --for 0s    # closes it\n"},
                        [options](Tool& tool) { return permit(tool, *options); });
  add_duration_option(app, "--for", options->time, "how long, at most 254s; default 60s");
  app->add_option("--via", options->via, "only through this router, named as for the other commands")
      ->type_name("DEVICE");
}

}  // namespace rubicon::cli::zigbee
