#include <fcntl.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "apps/rubicon/knx/bus.h"
#include "apps/rubicon/knx/commands.h"
#include "apps/rubicon/output/tuple_text.h"
#include "base/own_file.h"
#include "model/json_members.h"
#include "model/json_text.h"
#include "networks/knx/capture.h"
#include "networks/knx/wire/address.h"

namespace rubicon::cli::knx {

namespace {

using namespace std::chrono_literals;
using networks::knx::wire::parse_group;
using nlohmann::json;

/// The network replies within its own 7 s, also to a read that no device answers.
constexpr Duration kPatience = 10s;

struct Options {
  BusOptions bus;
  std::string address, dpt, value, file;
  std::vector<std::string> only;
};

std::string value_text(const json& telegram) {
  auto text = model::text_of(telegram, "value");
  if (text.empty()) return model::text_of(telegram, "hex");
  const auto unit = model::text_of(telegram, "unit");
  return unit.empty() ? text : text + " " + unit;
}

/// For JSON: a value that is a number is one there too.
json with_number(json telegram) {
  if (const auto number = telegram.find("number"); number != telegram.end()) {
    telegram["value"] = *number;
    telegram.erase("number");
  }
  return telegram;
}

int read(ToolLine& bus, const Settings& settings, const Options& options) {
  json request{{"do", "read"}, {"address", options.address}};
  if (!options.dpt.empty()) request["dpt"] = options.dpt;
  auto answer = bus.reply_to(request, kPatience);
  if (!model::flag_of(answer, "ok")) return refused(answer);
  answer.erase("id");
  bus.out().line(settings.json ? model::dump(with_number(std::move(answer))) : printable(value_text(answer)));
  return kGood;
}

int write(ToolLine& bus, const Settings& settings, const Options& options) {
  auto answer = bus.reply_to(
      {{"do", "write"}, {"address", options.address}, {"dpt", options.dpt}, {"value", options.value}}, kPatience);
  if (!model::flag_of(answer, "ok")) return refused(answer);
  answer.erase("id");
  bus.out().line(settings.json
                     ? model::dump(answer)
                     : fmt::format("sent {} to {}", model::text_of(answer, "hex"), model::text_of(answer, "address")));
  return kGood;
}

std::string telegram_line(const json& telegram) {
  const auto name = model::text_of(telegram, "name");
  const auto dpt = model::text_of(telegram, "dpt");
  return fmt::format("{}  {:<9}{:<11}{:<9}{:<8}{}{}{}", clock_text(model::time_of(telegram, "time")),
                     model::flag_of(telegram, "own") ? "own" : model::text_of(telegram, "source"),
                     model::text_of(telegram, "address"), model::text_of(telegram, "service"), dpt.empty() ? "-" : dpt,
                     value_text(telegram), name.empty() ? "" : "  ", name);
}

/// True for the addresses of the command line, in whatever notation, or without any.
bool is_shown(const Options& options, const json& telegram) {
  if (options.only.empty()) return true;
  const auto address = parse_group(model::text_of(telegram, "address"));
  return address && std::any_of(options.only.begin(), options.only.end(),
                                [&](const auto& text) { return *parse_group(text) == *address; });
}

int monitor(ToolLine& bus, const Settings& settings, const Options& options) {
  bus.on_event = [&](const json& telegram) {
    if (!is_shown(options, telegram)) return;
    bus.out().line(settings.json ? model::dump(with_number(telegram)) : printable(telegram_line(telegram)));
  };
  bus.on_line = [](bool up, const std::string& why) {
    print_error(up ? "the line is back" : printable("the line is lost: " + why));
  };
  return monitor_traffic(bus);
}

/// The frames of a reply. Malformed entries are left out.
std::vector<networks::knx::Capture::Frame> frames_in(const json& answer) {
  std::vector<networks::knx::Capture::Frame> frames;
  const auto found = answer.find("frames");
  if (found == answer.end() || !found->is_array()) return frames;
  for (const auto& one : *found) {
    auto cemi = base::from_hex(model::text_of(one, "cemi"));
    if (!cemi || cemi->empty()) continue;
    auto& frame = frames.emplace_back();
    frame.number = model::count_of(one, "number");
    frame.time = WallTime(std::chrono::microseconds(model::count_of(one, "time")));
    frame.outgoing = model::flag_of(one, "out");
    frame.cemi = std::move(*cemi);
  }
  return frames;
}

/// Fetches all frames that the island keeps, in several requests.
int capture(ToolLine& bus, const Settings&, const Options& options) {
  auto target = OwnFile::open(options.file, O_WRONLY | O_TRUNC);
  if (!target) {
    print_error(target.error().text);
    return kFailed;
  }
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(
      ::fdopen(target->release(), "wb"),  // NOLINT(cppcoreguidelines-owning-memory)
      [](std::FILE* one) { return std::fclose(one); });
  const auto put = [&file](const Bytes& bytes) { std::fwrite(bytes.data(), 1, bytes.size(), file.get()); };
  put(networks::knx::pcap_file_header());
  std::uint64_t next = 0, frames = 0;
  for (bool more = true; more;) {
    const auto answer = bus.reply_to({{"do", "capture"}, {"from", next}}, kPatience);
    if (!model::flag_of(answer, "ok")) return refused(answer);
    const auto before = next;
    for (const auto& frame : frames_in(answer)) {
      put(networks::knx::pcap_record(frame));
      next = std::max(next, frame.number + 1);
      ++frames;
    }
    more = model::flag_of(answer, "more") && next > before;
  }
  if (std::fflush(file.get()) != 0 || std::ferror(file.get()) != 0) {
    print_error(fmt::format("{} cannot be written", options.file));
    return kFailed;
  }
  bus.out().line(fmt::format("{} in {}", counted(frames, "frame"), options.file));
  return kGood;
}

/// The error of the first argument that is not a group address; empty if all are.
std::string address_error(const Options& options) {
  auto all = options.only;
  if (!options.address.empty()) all.push_back(options.address);
  for (const auto& text : all) {
    if (const auto address = parse_group(text); !address) return address.error().text;
  }
  return {};
}

using Command = int (*)(ToolLine&, const Settings&, const Options&);

CLI::App* add(Cli& cli, CLI::App* parent, const Cli::Text& text, const std::shared_ptr<Options>& options,
              Command command) {
  auto* app = cli.command({text.name, text.summary, text.examples, parent},
                          [options, command, name = "knx " + text.name](const Settings& settings) -> int {
                            if (const auto wrong = address_error(*options); !wrong.empty()) {
                              print_error(wrong);
                              return kUsage;
                            }
                            int code = kFailed;
                            const auto bus = open_bus(settings, options->bus, name, code);
                            if (!bus) return code;
                            code = command(*bus, settings, *options);
                            bus->out().flush();
                            return code;
                          });
  auto* direct = app->add_option("--direct", options->bus.direct,
                                 "do not use an island: open a tunnel to this KNXnet/IP interface")
                     ->type_name("HOST[:PORT]");
  app->add_flag("--knx-tcp", options->bus.tcp, "with --direct: by TCP; always with --keyring")->needs(direct);
  auto* keyring = app->add_option("--keyring", options->bus.keyring,
                                  "with --direct: a secure tunnel, and secured groups, with this keyring of ETS")
                      ->type_name("FILE")
                      ->check([](const std::string& name) { return std::string(name.empty() ? "no file" : ""); })
                      ->needs(direct);
  app->add_option("--password-file", options->bus.password_file,
                  "file with the password of the keyring; default: RUBICON_KNX_PASSWORD")
      ->type_name("FILE")
      ->needs(keyring);
  app->add_option("--server", options->bus.server, "the interface's individual address, if the keyring has several")
      ->type_name("ADDRESS")
      ->needs(keyring);
  app->add_option("--tunnel-address", options->bus.tunnel_address,
                  "use this tunnel of the keyring, because an island may use the first one")
      ->type_name("ADDRESS")
      ->needs(keyring);
  app->add_option("--group-keys", options->bus.group_keys,
                  "with --direct: secured groups with the keys of this file (option group-keys-file of a network)")
      ->type_name("FILE")
      ->needs(direct);
  options->bus.network.add_to(app, "knx-hall")->excludes(direct);
  app->get_option("--island")->excludes(direct);
  return app;
}

}  // namespace

void add_bus(Cli& cli, CLI::App* parent) {
  const auto options = std::make_shared<Options>();
  auto* app =
      add(cli, parent,
          {"monitor", "Print the telegrams of the bus as they arrive, decoded",
           "  rubicon knx monitor\n"
           "  rubicon knx monitor 1/2/7 1/2/8\n"
           "  rubicon knx monitor --direct 192.168.1.10\n"
           "  rubicon knx monitor --direct 192.168.1.10 --keyring hall.knxkeys --password-file hall.password\n"},
          options, monitor);
  app->add_option("GA", options->only, "only these group addresses");
  app = add(cli, parent,
            {"read", "Read the value of a group address from the bus",
             "  rubicon knx read 1/2/7\n"
             "  rubicon knx read 1/2/7 9.001 --direct 192.168.1.10\n"},
            options, read);
  app->add_option("GA", options->address, "group address: 1/2/7; 1/519 and 2567 are the same")->required();
  app->add_option("DPT", options->dpt, "data point type; default: the configured one");
  app = add(cli, parent,
            {"write", "Write a value to a group address",
             "  rubicon knx write 1/0/1 1.001 on\n"
             "  rubicon knx write 1/2/7 9.001 21.5 --direct 192.168.1.10\n"},
            options, write);
  app->add_option("GA", options->address, "group address: 1/2/7; 1/519 and 2567 are the same")->required();
  app->add_option("DPT", options->dpt, "data point type: 9.001")->required();
  app->add_option("VALUE", options->value, "in the words and unit of the type: 21.5, on, comfort, JSON")->required();
  app = add(cli, parent,
            {"capture", "Save the telegrams of the last minutes, for a protocol analyser",
             "  rubicon knx capture bus.pcap\n"},
            options, capture);
  app->add_option("FILE", options->file, "the pcap file to write")->required();
}

}  // namespace rubicon::cli::knx
