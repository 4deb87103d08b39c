#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace rubicon::examples {

/// A command line that a text shows.
struct Example {
  std::string place;  ///< `docs/cli.md:12`, `rubicon watch --help`
  std::string line;

  friend bool operator==(const Example&, const Example&) = default;
};

/// Of a page: lines of its code blocks (indented by four or more blanks, or fenced) that begin with one of our
/// programs, with `curl`, which asks one, or with `printf`, which writes a file for them; a `$ ` or a path of the build
/// tree may stand in front.
std::vector<Example> examples_of_page(const std::string& name, const std::string& text);
/// Of what `--help` prints, or of the source of a manual page: lines that begin with one of our programs.
std::vector<Example> examples_of_help(const std::string& name, const std::string& text);

/// Shows how a command line is built, and none that one could type: `FILE`, `[OLD]`, `...`.
bool is_synopsis(const std::string& line);

}  // namespace rubicon::examples
