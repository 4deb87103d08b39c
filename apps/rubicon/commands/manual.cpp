#include <fmt/format.h>
#include <fmt/ranges.h>

#include "apps/rubicon/cli.h"
#include "apps/rubicon/commands/completion.h"

namespace rubicon::cli {

namespace {

/// Text as troff takes it.
std::string troff(std::string_view text) {
  std::string out;
  bool line_begins = true;
  for (const char c : text) {
    if (line_begins && (c == '.' || c == '\'')) out += "\\&";
    line_begins = c == '\n';
    if (c == '\\') {
      out += "\\e";
    } else if (c == '-') {
      out += "\\-";
    } else {
      out += c;
    }
  }
  return out;
}

std::string options_of(const CLI::App& app) {
  std::string out;
  for (const auto* option : app.get_options()) {
    if (option->get_group().empty()) continue;
    auto name = option->get_positional() ? option->get_name(true) : option->get_name(false, true);
    std::string shown;
    for (const char c : name) shown += c == ',' ? std::string(", ") : std::string(1, c);
    if (!option->get_positional() && option->get_items_expected_max() > 0)
      shown += " " + (option->get_type_name().empty() ? std::string("VALUE") : option->get_type_name());
    out += fmt::format(".TP\n.B {}\n{}\n", troff(shown), troff(option->get_description()));
  }
  return out;
}

std::string example_of(const CLI::App& app) {
  const auto& footer = app.get_footer();
  const auto end = footer.find("Options of all commands");
  auto text = troff(footer.substr(0, end));
  if (!text.ends_with('\n')) text += '\n';
  return ".PP\n.EX\n" + text + ".EE\n";
}

/// The shown subcommands, and those that they have themselves.
std::string commands_of(const CLI::App& app, const std::string& before) {
  std::string out;
  for (const auto* one : app.get_subcommands([](const CLI::App* sub) { return !sub->get_group().empty(); })) {
    const auto name = before + one->get_name();
    out +=
        fmt::format(".SS {}\n{}\n{}{}", troff(name), troff(one->get_description()), options_of(*one), example_of(*one));
    out += commands_of(*one, name + " ");
  }
  return out;
}

std::string environment_of(const CLI::App& app) {
  std::vector<std::string> names;
  for (const auto* option : app.get_options()) {
    if (!option->get_envname().empty() && !option->get_group().empty()) names.push_back(option->get_envname());
  }
  return fmt::format(
      ".SH ENVIRONMENT\n{}\nstand for the options of these names; what is on the command line wins.\n"
      "NO_COLOR turns colours off. RUBICON_KNX_PASSWORD is a password of ETS.\n",
      fmt::join(names, ", "));
}

constexpr const char* kFiles =
    ".SH FILES\n"
    ".TP\n.I /etc/rubicon/realm/\nthe part of this host in a realm of MQTT brokers; \\fIca/\\fR only where members are "
    "added\n"
    ".TP\n.I \\(ti/.config/rubicon/realm/\nthat of one person\n"
    ".TP\n.I /etc/rubicon/broker/\nbrokers of this host, which rubicon-broker@ runs\n"
    ".TP\n.I /etc/rubicon/*.yaml\nthe islands of this host\n";

/// rubicon(1), from what --help says.
std::string manual(const CLI::App& app) {
  auto out = fmt::format(
      ".TH RUBICON 1 \"\" \"rubicon {}\" \"User Commands\"\n.SH NAME\nrubicon \\- see, watch and command the islands "
      "of "
      "RUBICON\n.SH SYNOPSIS\n.B rubicon\n[OPTIONS] COMMAND ...\n.SH DESCRIPTION\n{}\n.SH COMMANDS\n",
      RUBICON_VERSION, troff(app.get_description()));
  out += commands_of(app, "");
  out += ".SH OPTIONS\nOptions may precede or follow the command.\n" + options_of(app);
  out += fmt::format(".SH EXIT STATUS\n{}\n", troff(kExitCodes));
  return out + environment_of(app) + kFiles + ".SH SEE ALSO\n.BR rubicon\\-proxy (1)\n";
}

int completion(const std::string& shell) {
  Output out(1);
  out.write(shell == "zsh" ? kZshCompletion : kBashCompletion);
  return ended(out, kGood);
}

}  // namespace

void add_manual(Cli& cli) {
  const auto shell = std::make_shared<std::string>();
  auto* app = cli.command({"completion", "Print the completion of a shell",
                           "  . <(rubicon completion bash)\n"
                           "  rubicon completion zsh > ~/.zfunc/_rubicon\n"},
                          [shell](const Settings&) { return completion(*shell); });
  app->add_option("SHELL", *shell, "bash or zsh")->required()->check(CLI::IsMember({"bash", "zsh"}));
  app = cli.command({"manual", "Print the manual page", "  rubicon manual | man -l -\n"}, [&cli](const Settings&) {
    Output out(1);
    out.write(manual(cli.app()));
    return ended(out, kGood);
  });
  app->group("");
}

}  // namespace rubicon::cli
