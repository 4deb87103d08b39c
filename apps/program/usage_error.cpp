#include "apps/program/usage_error.h"

#include "base/compare_text.h"

namespace rubicon::program {

namespace {

/// The innermost command that the words reached.
const CLI::App& reached(const CLI::App& app) {
  const auto inner = app.get_subcommands();
  return inner.empty() ? app : reached(*inner.back());
}

std::vector<std::string> commands_of(const CLI::App& app) {
  std::vector<std::string> names;
  for (const auto* one : app.get_subcommands([](const CLI::App* sub) { return !sub->get_group().empty(); }))
    names.push_back(one->get_name());
  return names;
}

/// Of the command and, behind it, of the program.
std::vector<std::string> options_of(const CLI::App* app) {
  std::vector<std::string> names;
  for (; app; app = app->get_parent()) {
    for (const auto* option : app->get_options()) {
      for (const auto& name : option->get_lnames()) names.push_back("--" + name);
    }
  }
  return names;
}

/// `rubicon knx`.
std::string path_of(const CLI::App& app) {
  const auto* above = app.get_parent();
  return above ? path_of(*above) + " " + app.get_name() : app.get_name();
}

std::string with_question(std::string text, const std::string& question, const CLI::App& app) {
  return text + "; " + (question.empty() ? "`" + path_of(app) + " --help` lists what there is" : question);
}

/// The first word that belongs to nothing; empty if there is none.
std::string stray_word(const CLI::App& app) {
  const auto words = app.remaining(true);
  return words.empty() ? std::string() : words.front();
}

}  // namespace

std::string explain(const CLI::App& app, const CLI::ParseError& error) {
  const auto& inner = reached(app);
  auto word = stray_word(app);
  const auto commands = commands_of(inner);
  if (word.empty() && inner.get_require_subcommand_min() > 0 && inner.get_subcommands().empty())
    return with_question("expected a command", {}, inner);
  if (word.empty()) return error.what();
  if (word.starts_with("-")) {
    word = word.substr(0, word.find('='));
    return with_question("unknown option '" + word + "'", base::did_you_mean(word, options_of(&inner)), inner);
  }
  if (commands.empty()) return with_question("unexpected word '" + word + "'", {}, inner);
  return with_question("unknown command '" + word + "'", base::did_you_mean(word, commands), inner);
}

}  // namespace rubicon::program
