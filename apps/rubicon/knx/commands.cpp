#include "apps/rubicon/knx/commands.h"

#include <cstdio>
#include <iostream>
#include <memory>
#include <string>

#include "networks/knx/dpt/convert_line.h"

namespace rubicon::cli {

void add_knx(Cli& cli) {
  auto* app =
      cli.app().add_subcommand("knx", "Tools for KNX: discover, monitor, read, write, import, keyring, decode, encode");
  app->require_subcommand(1);
  app->fallthrough();
  app->get_formatter()->label("SUBCOMMAND", "COMMAND");
  app->footer(
      "Examples:\n"
      "  rubicon knx discover\n"
      "  rubicon knx import flat.csv > flat.yaml\n"
      "  rubicon knx monitor\n"
      "  rubicon knx write 1/0/1 1.001 on\n"
      "monitor, read, write and capture use the line of the running island, as an interface has few tunnels;\n"
      "--direct HOST opens another tunnel.");
  knx::add_discover(cli, app);
  knx::add_bus(cli, app);
  knx::add_import(cli, app);
  knx::add_keyring(cli, app);
  knx::add_convert(cli, app);
}

}  // namespace rubicon::cli

namespace rubicon::cli::knx {

namespace {

struct Words {
  std::string type;
  std::vector<std::string> value;
};

using Convert = std::string (*)(std::string_view line);

std::string joined(const Words& words) {
  std::string line = words.type;
  for (const auto& word : words.value) line += " " + word;
  return line;
}

int convert_lines(Convert convert) {
  Output out(1);
  bool good = true;
  for (std::string line; std::getline(std::cin, line) && !out.broken();) {
    const auto answer = convert(line);
    good = good && !answer.starts_with("error:");
    out.line(answer);
    if (std::cin.rdbuf()->in_avail() == 0) out.flush();  // the program at the other end may wait for the answer
  }
  return ended(out, good ? kGood : kFailed);
}

int convert(const Words& words, Convert how) {
  if (words.type.empty()) return convert_lines(how);
  const auto answer = how(joined(words));
  if (answer.starts_with("error: ")) {
    print_error(std::string_view(answer).substr(7));
    return kUsage;
  }
  Output out(1);
  out.line(answer);
  return ended(out, kGood);
}

void add(Cli& cli, CLI::App* under, const Cli::Text& text, Convert how, const std::string& about) {
  const auto words = std::make_shared<Words>();
  auto* app = cli.command({text.name, text.summary, text.examples, under},
                          [words, how](const Settings&) { return convert(*words, how); });
  app->add_option("DPT", words->type, "9.001, 9.1, DPST-9-1, 9; without it lines `DPT ...` come from standard input");
  app->add_option(about.substr(0, about.find(':')), words->value, about.substr(about.find(':') + 2));
}

}  // namespace

void add_convert(Cli& cli, CLI::App* under) {
  add(cli, under,
      {"decode", "Decode the bytes of a telegram",
       "  rubicon knx decode 9.001 0c33\n"
       "  printf '9.001 0c33\\n1.001 01\\n' | rubicon knx decode    # prints per line the value or `error: ...`\n"},
      networks::knx::dpt::decode_line, "HEX: the bytes; 0c33 or 0c 33");
  add(cli, under,
      {"encode", "Encode a value as the bytes of a telegram",
       "  rubicon knx encode 9.001 21.5\n"
       "  rubicon knx encode 10.001 Fri 13:30:15\n"
       "  printf '5.001 50\\n' | rubicon knx encode    # prints per line the hex digits or `error: ...`\n"},
      networks::knx::dpt::encode_line, "VALUE: in the words and unit of the type: 21.5, on, comfort, 2026-11-20, JSON");
}

}  // namespace rubicon::cli::knx
