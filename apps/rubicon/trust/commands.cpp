#include "apps/rubicon/trust/commands.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "apps/rubicon/trust/site/commands.h"
#include "base/own_file.h"
#include "base/text.h"
#include "trust/site/site_place.h"

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
      "The folder is /etc/rubicon/realm, that of a person ~/.config/rubicon/realm; --realm FOLDER or RUBICON_REALM\n"
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

constexpr std::size_t kLargestText = 256 * 1024;
constexpr mode_t kPrivate = 0600;

Result<std::string> read_all(int descriptor, const std::string& name) {
  std::string text(kLargestText + 1, '\0');
  std::size_t done = 0;
  while (done < text.size()) {
    const auto count = ::read(descriptor, text.data() + done, text.size() - done);
    if (count < 0) return fail(ErrorCode::kIo, fmt::format("{}: cannot be read: {}", name, std::strerror(errno)));
    if (count == 0) break;
    done += static_cast<std::size_t>(count);
  }
  if (done > kLargestText)
    return fail(ErrorCode::kOutOfRange, fmt::format("{}: has more than {} bytes", name, kLargestText));
  text.resize(done);
  return text;
}

std::optional<unsigned> number_in(const char* variable) {
  const char* value = std::getenv(variable);
  return value ? base::parse_number<unsigned>(value) : std::nullopt;
}

/// Who ran sudo carries the file to another host.
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
