#include "apps/rubicon/trust/phrase.h"

#include <fmt/format.h>
#include <termios.h>
#include <unistd.h>

#include <cctype>
#include <cstdio>
#include <tuple>
#include <utility>

#include "apps/rubicon/trust/commands.h"
#include "base/text.h"

namespace rubicon::cli::trust {

namespace {

constexpr std::size_t kLongestPhrase = 1024;

/// The terminal does not show what is typed while it lives.
class Silence {
 public:
  Silence() : changed_(::tcgetattr(STDIN_FILENO, &before_) == 0) {
    if (!changed_) return;
    auto silent = before_;
    silent.c_lflag &= ~static_cast<tcflag_t>(ECHO);
    silent.c_lflag |= ECHONL;
    ::tcsetattr(STDIN_FILENO, TCSAFLUSH, &silent);
  }
  ~Silence() {
    if (changed_) ::tcsetattr(STDIN_FILENO, TCSAFLUSH, &before_);
  }
  Silence(const Silence&) = delete;
  Silence& operator=(const Silence&) = delete;

 private:
  termios before_{};
  bool changed_;
};

/// Byte by byte: what follows the line is for others. With room for all of it: what grows leaves copies behind.
SecretText line_of_input() {
  std::string line;
  line.reserve(kLongestPhrase);
  char c = 0;
  while (line.size() < kLongestPhrase && ::read(STDIN_FILENO, &c, 1) == 1 && c != '\n') line += c;
  if (line.ends_with('\r')) line.pop_back();
  return SecretText(std::move(line));
}

void ask(const std::string& question) {
  std::fputs(question.c_str(), stderr);
  std::fflush(stderr);
}

Result<SecretText> phrase_in(const std::string& file) {
  auto text = read_text(file);
  if (!text) return fail(text.error());
  const SecretText all(std::move(*text));
  const auto line = all.view().substr(0, all.view().find_first_of("\r\n"));
  return SecretText(std::string(line));
}

SecretText typed_phrase(const std::string& question) {
  if (!::isatty(STDIN_FILENO)) return line_of_input();
  const Silence silence;
  ask(question);
  return line_of_input();
}

}  // namespace

Result<SecretText> read_phrase(const PhraseOptions& options, const std::string& question) {
  auto phrase = options.file.empty() ? Result<SecretText>(typed_phrase(question)) : phrase_in(options.file);
  if (phrase && phrase->empty())
    return fail(ErrorCode::kInvalid, fmt::format("{}: no pass phrase, expected one line",
                                                 options.file.empty() ? "standard input" : options.file));
  return phrase;
}

Result<void> may_show_phrase(bool json) {
  if (json) return fail(ErrorCode::kInvalid, "the pass phrase is no part of the JSON; expected --phrase-file FILE");
  if (::isatty(STDOUT_FILENO)) return {};
  return fail(ErrorCode::kInvalid,
              "the pass phrase is shown on a terminal only, and standard output is none; expected --phrase-file FILE");
}

/// Not by the buffer of standard output, which keeps it.
void show_phrase(std::string_view phrase) {
  std::fflush(stdout);
  for (const auto part : {std::string_view("phrase       "), phrase, std::string_view("\n")})
    std::ignore = ::write(STDOUT_FILENO, part.data(), part.size());
}

Result<bool> confirmed(const std::string& question) {
  if (!::isatty(STDIN_FILENO))
    return fail(ErrorCode::kInvalid, "standard input is no terminal to confirm on, expected --yes");
  ask(question + " [y/N] ");
  std::string answer(base::trimmed(line_of_input().view()));
  for (auto& c : answer) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return answer == "y" || answer == "yes";
}

}  // namespace rubicon::cli::trust
