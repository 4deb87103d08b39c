#include "apps/rubicon/trust/commands.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

#include <cctype>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <tuple>
#include <utility>

#include "apps/rubicon/trust/site/commands.h"
#include "base/own_file.h"
#include "base/text.h"
#include "trust/site/site_identity.h"

namespace rubicon::cli::trust {

namespace {

constexpr std::size_t kMaxPhrase = 1024;

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
  line.reserve(kMaxPhrase);
  char c = 0;
  while (line.size() < kMaxPhrase && ::read(STDIN_FILENO, &c, 1) == 1 && c != '\n') line += c;
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
  return fail(
      ErrorCode::kInvalid,
      "the pass phrase is shown only on a terminal, and standard output is not one; expected --phrase-file FILE");
}

/// Not by the buffer of standard output, which keeps it.
void show_phrase(std::string_view phrase) {
  std::fflush(stdout);
  for (const auto part : {std::string_view("phrase       "), phrase, std::string_view("\n")})
    std::ignore = ::write(STDOUT_FILENO, part.data(), part.size());
}

Result<bool> confirmed(const std::string& question) {
  if (!::isatty(STDIN_FILENO))
    return fail(ErrorCode::kInvalid, "standard input is not a terminal to confirm on, expected --yes");
  ask(question + " [y/N] ");
  std::string answer(base::trimmed(line_of_input().view()));
  for (auto& c : answer) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return answer == "y" || answer == "yes";
}

}  // namespace rubicon::cli::trust

namespace rubicon::cli {

namespace {

/// Commands of earlier releases.
void add_former(Cli& cli, CLI::App* parent) {
  for (const std::string name : {"dds", "request", "sign", "export"}) {
    auto* app = cli.command({name, "Was for certificates of DDS", "", parent}, [name](const Settings&) {
      return trust::failed(
          {ErrorCode::kInvalid,
           fmt::format("`rubicon trust {}`: this release has no certificates for DDS; components that "
                       "use it are `lan` in rights (docs/trust.md); hosts that do not trust each other meet "
                       "at a broker with a realm (docs/sites.md)",
                       name)});
    });
    app->allow_extras()->fallthrough(false);
    app->group("");
  }
}

}  // namespace

void add_trust(Cli& cli) {
  auto* app = cli.app().add_subcommand("trust",
                                       "Who may take part: init, add, join, revoke, renew, change, show, broker; "
                                       "may, audit");
  app->require_subcommand(1);
  app->fallthrough();
  app->get_formatter()->label("SUBCOMMAND", "COMMAND");
  app->footer(
      "Examples:\n"
      "  sudo rubicon trust init --broker broker.example.org    # on the host with the broker\n"
      "  sudo rubicon trust broker mosquitto\n"
      "  sudo rubicon trust add hall --island 6541              # writes hall.trust, shows its phrase\n"
      "  sudo rubicon trust join hall.trust                     # on the other host\n"
      "  sudo rubicon trust revoke hall\n"
      "  rubicon trust may desk set proxy.hall.door.actuator.lock-1.command\n"
      "The folder is /etc/rubicon/realm for root, ~/.config/rubicon/realm for others; --realm FOLDER or RUBICON_REALM\n"
      "name another one. See docs/sites.md and docs/trust.md.");
  trust::site::add_site(cli, app);
  trust::add_may(cli, app);
  trust::add_audit(cli, app);
  add_former(cli, app);
}

namespace trust {

namespace {

namespace fs = std::filesystem;
using rubicon::trust::KeyReaders;

constexpr std::size_t kMaxTextSize = 256 * 1024;
constexpr mode_t kPrivate = 0600;

Result<std::string> read_all(int descriptor, const std::string& name) {
  std::string text(kMaxTextSize + 1, '\0');
  std::size_t done = 0;
  while (done < text.size()) {
    const auto count = ::read(descriptor, text.data() + done, text.size() - done);
    if (count < 0) return fail(ErrorCode::kIo, fmt::format("{}: cannot be read: {}", name, std::strerror(errno)));
    if (count == 0) break;
    done += static_cast<std::size_t>(count);
  }
  if (done > kMaxTextSize)
    return fail(ErrorCode::kOutOfRange, fmt::format("{}: has more than {} bytes", name, kMaxTextSize));
  text.resize(done);
  return text;
}

std::optional<unsigned> number_in(const char* variable) {
  const char* value = std::getenv(variable);
  return value ? base::parse_number<unsigned>(value) : std::nullopt;
}

/// The user who ran sudo carries the file to another host.
void give_to_sudo_user(int descriptor) {
  const auto user = number_in("SUDO_UID"), group = number_in("SUDO_GID");
  if (::geteuid() == 0 && user && group) std::ignore = ::fchown(descriptor, *user, *group);
}

}  // namespace

Result<KeyReaders> key_readers(bool for_people) {
  if (!for_people) return KeyReaders::kOwner;
  if (::geteuid() != 0)
    return fail(ErrorCode::kRefused, "--people gives a key to the group rubicon of this host: expected root (sudo)");
  if (!rubicon::trust::people_group())
    return fail(ErrorCode::kNotFound,
                "--people: this host has no group rubicon; `sudo addgroup --system rubicon` makes one");
  return KeyReaders::kPeople;
}

WallTime now() {
  return std::chrono::floor<std::chrono::microseconds>(std::chrono::system_clock::now());
}

int failed(const Error& error) {
  print_error(printable(error.text));
  return error.code == ErrorCode::kInvalid || error.code == ErrorCode::kOutOfRange ? kUsage : kFailed;
}

int failed_at(const fs::path& folder, const Error& error) {
  if (folder != fs::path(rubicon::trust::site::kHostSiteFolder) || ::geteuid() == 0 ||
      error.code == ErrorCode::kInvalid)
    return failed(error);
  return failed({error.code, error.text + "; the folder of the host is changed by root: sudo rubicon trust ..."});
}

Line as_json(const RealmIdentity& realm) {
  return {{"name", realm.name}, {"fingerprint", realm.fingerprint}};
}

void put(Output& out, const RealmIdentity& realm) {
  out.line("realm        " + printable(realm.name));
  out.line("fingerprint  " + printable(realm.fingerprint));
}

Result<std::string> read_text(const std::string& file) {
  if (file == "-") return read_all(STDIN_FILENO, "standard input");
  const int descriptor = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return fail(ErrorCode::kIo, fmt::format("{}: cannot be opened: {}", file, std::strerror(errno)));
  auto text = read_all(descriptor, file);
  ::close(descriptor);
  return text;
}

Result<NewFile> NewFile::open(const std::string& path) {
  if (std::error_code error; fs::exists(fs::symlink_status(path, error)))
    return fail(ErrorCode::kDuplicate, fmt::format("{}: exists, expected the name of a new file", path));
  const auto before = ::umask(0177);
  auto made = OwnFile::open(path, O_WRONLY | O_EXCL);
  ::umask(before);
  if (!made) return fail(made.error());
  NewFile file(path, std::move(*made));
  if (::fchmod(file.file_.get(), kPrivate) != 0)
    return fail(ErrorCode::kIo, fmt::format("{}: its mode cannot be set: {}", path, std::strerror(errno)));
  give_to_sudo_user(file.file_.get());
  return file;
}

NewFile::~NewFile() {
  if (!path_.empty() && !written_) ::unlink(path_.c_str());
}

Result<void> NewFile::write(std::string_view text) {
  const auto done = file_.write(text, path_);
  written_ = done.has_value();
  return done;
}

}  // namespace trust

}  // namespace rubicon::cli
