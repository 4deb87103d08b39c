#include <fmt/format.h>

#include <fcntl.h>
#include <grp.h>
#include <spawn.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "apps/rubicon/cli.h"
#include "apps/rubicon/output/tuple_text.h"
#include "base/own_file.h"
#include "config/config_file.h"
#include "config/service_config.h"
#include "model/json_members.h"
#include "transport/asio_scheduler.h"
#include "transport/local_transports.h"
#include "web/access/token_file.h"

namespace rubicon::cli {

namespace {

namespace fs = std::filesystem;

constexpr const char* kFolder = "/etc/rubicon";
/// What tools read there, and no island does.
constexpr const char* kOfTools = "ecology.yaml";
/// The user and group of installed islands, who read the tokens.
constexpr const char* kUnixGroup = "rubicon";
/// systemd makes copies there of files that only root may read.
constexpr std::string_view kCredentials = "/run/credentials/";

struct EnableOptions {
  std::string island, name = "admin", listen = "127.0.0.1:8642", tokens;
};

/// `home` or a path; without either the only file of an island in /etc/rubicon.
Result<std::string> file_of(const std::string& island) {
  std::error_code error;
  const auto installed = fmt::format("{}/{}.yaml", kFolder, island);
  if (!island.empty()) {
    const bool is_path = island.find('/') != island.npos || island.ends_with(".yaml");
    const auto path = is_path ? island : installed;
    if (!fs::exists(path, error)) return fail(ErrorCode::kNotFound, fmt::format("there is no file {}", path));
    return fs::canonical(path, error).string();
  }
  std::vector<std::string> found;
  for (const auto& one : fs::directory_iterator(kFolder, error)) {
    if (one.path().extension() == ".yaml" && one.path().filename() != kOfTools) found.push_back(one.path().string());
  }
  if (found.size() == 1) return found.front();
  return fail(ErrorCode::kInvalid, fmt::format("{} has {} of islands; name one: rubicon web enable NAME", kFolder,
                                               counted(found.size(), "file")));
}

Result<std::string> text_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  if (!in.is_open() || in.bad())
    return fail(ErrorCode::kIo, fmt::format("cannot read {}: {}", path, std::strerror(errno)));
  return text;
}

/// What a file says of its page; nullopt: nothing. The errors of the section are the caller's.
Result<std::optional<config::WebSetup>> page_in(const std::string& path) {
  auto root = config::load_config(path, {});
  if (!root) return fail(root.error());
  base::ConfigErrors errors;
  ConfigReader reader(*root, "", errors);
  auto setup = config::read_web(reader);
  if (!errors.empty()) return fail(ErrorCode::kInvalid, errors.text());
  return setup;
}

/// The text with tokens in the section `web:` that begins in the line `number`, from 1.
std::string with_tokens(const std::string& text, int number, const std::string& tokens) {
  std::size_t begin = 0;
  for (int line = 1; line < number; ++line) begin = text.find('\n', begin) + 1;
  const auto end = std::min(text.find('\n', begin), text.size());
  const auto brace = text.find('{', begin);
  if (brace < end) {
    const auto next = text.find_first_not_of(" \t", brace + 1);
    const bool is_empty = next != text.npos && text[next] == '}';
    return text.substr(0, brace + 1) + tokens + (is_empty ? "" : ", ") + text.substr(brace + 1);
  }
  const auto below = text.find_first_not_of('\n', end);
  const auto word = below == text.npos ? text.npos : text.find_first_not_of(' ', below);
  const auto indent = word == text.npos || word == below ? std::string("  ") : text.substr(below, word - below);
  return text.substr(0, end) + "\n" + indent + tokens + text.substr(end);
}

/// The file with a page whose callers need tokens.
Result<std::string> with_page(const std::string& path, const std::string& text, const EnableOptions& options) {
  const auto root = config::load_config(path, {});
  if (!root) return fail(root.error());
  const auto tokens = fmt::format("tokens: {{file: {}}}", options.tokens);
  if (const auto* web = root->find("web")) return with_tokens(text, web->key_place().line, tokens);
  return fmt::format(
      "{}{}\nweb:                                    # the page in a browser, and its API (docs/web.md)\n"
      "  listen: \"{}\"\n  {}\n",
      text, text.empty() || text.ends_with('\n') ? "" : "\n", options.listen, tokens);
}

/// What `rubicon-proxy check` finds in a file; the program of the same installation. Empty: nothing is wrong.
Result<void> checked_by_daemon(const std::string& path) {
  std::error_code error;
  const auto beside = fs::read_symlink("/proc/self/exe", error).parent_path() / "rubicon-proxy";
  auto program = fs::exists(beside, error) ? beside.string() : std::string("rubicon-proxy");
  std::string check = "check", elsewhere = "--elsewhere", file = path;
  const std::array<char*, 5> words{program.data(), check.data(), elsewhere.data(), file.data(), nullptr};
  posix_spawn_file_actions_t quiet;  // what is right needs no words
  ::posix_spawn_file_actions_init(&quiet);
  ::posix_spawn_file_actions_addopen(&quiet, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  pid_t child = 0;
  int status = 0;
  const int failed = ::posix_spawnp(&child, program.c_str(), &quiet, nullptr, words.data(), environ);
  ::posix_spawn_file_actions_destroy(&quiet);
  if (failed != 0)
    return fail(ErrorCode::kIo, fmt::format("rubicon-proxy, which checks the file: {}", std::strerror(failed)));
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return {};
  return fail(ErrorCode::kInvalid, "`rubicon-proxy check` does not accept the file, which stays as it was");
}

Error cannot_write(const std::string& path) {
  return {ErrorCode::kRefused, fmt::format("cannot write {}: {}", path, std::strerror(errno))};
}

/// Writes a file of the owner, group and mode of another one.
Result<void> write_like(const std::string& like, const std::string& path, const std::string& text) {
  struct stat about {};
  if (::stat(like.c_str(), &about) != 0) return fail(cannot_write(path));
  const auto file = base::OwnFile::open(path, O_WRONLY | O_TRUNC);
  if (!file) return fail(file.error());
  std::ignore = ::fchown(file->get(), about.st_uid, about.st_gid);  // of another user only root may
  if (::fchmod(file->get(), about.st_mode & 07777U) != 0) return fail(cannot_write(path));
  return file->write(text, path);
}

/// Replaces the file by what was checked; the previous one is kept beside it.
Result<void> replace(const std::string& path, const std::string& before, const std::string& text) {
  const auto next = path + ".new";
  auto done = write_like(path, next, text);
  if (done) done = checked_by_daemon(next);
  if (done) done = write_like(path, path + ".previous", before);
  if (done && ::rename(next.c_str(), path.c_str()) != 0) done = fail(cannot_write(path));
  if (!done) ::unlink(next.c_str());
  return done;
}

/// The token, or nothing where the name has one already.
Result<std::optional<std::string>> token_for(const std::string& path, const std::string& name) {
  if (path.starts_with(kCredentials))
    return fail(ErrorCode::kRefused,
                fmt::format("systemd makes {} of a file that the unit names (LoadCredential): `rubicon token {} --role "
                            "admin --file` with that file, then restart the unit",
                            path, name));
  transport::Loop loop;
  transport::LocalTransports transports(loop);
  auto token = web::access::add_token(transports, path, name, web::Role::kAdmin);
  if (!token && token.error().code == ErrorCode::kDuplicate) return std::optional<std::string>();
  if (!token) return fail(token.error());
  const auto* group = ::geteuid() == 0 ? ::getgrnam(kUnixGroup) : nullptr;
  if (group != nullptr && ::chown(path.c_str(), static_cast<uid_t>(-1), group->gr_gid) != 0)
    return fail(cannot_write(path));
  return std::optional(std::move(*token));
}

std::string address_of(const config::WebSetup& setup) {
  auto place = setup.listen;
  if (!setup.hosts.empty()) place.host = setup.hosts.front();
  if (place.host == "0.0.0.0" || place.host == "::") place.host = "localhost";
  const auto host = place.host.find(':') == place.host.npos ? place.host : "[" + place.host + "]";
  return fmt::format("{}://{}:{}", setup.tls ? "https" : "http", host, place.port);
}

int tell(const Settings& settings, const std::string& path, const config::WebSetup& page, const std::string& tokens,
         const std::string& name, const std::optional<std::string>& token) {
  Output out(1);
  const bool is_installed = path.starts_with(std::string(kFolder) + "/");
  const auto unit = "rubicon-proxy@" + fs::path(path).stem().string();
  if (settings.json) {
    nlohmann::ordered_json line{{"file", path}, {"address", address_of(page)}, {"tokens", tokens}, {"name", name}};
    if (token) line["token"] = *token;
    out.line(model::dump(line));
    return ended(out, kGood);
  }
  out.line("open   " + address_of(page));
  out.line(token ? fmt::format("token  {}   ({}, role admin; kept nowhere, so note it)", *token, name)
                 : fmt::format("token  {} has one already; `rubicon token NAME --role admin --file {}` makes another",
                               name, tokens));
  out.line(is_installed ? fmt::format("then   sudo systemctl reload {}", unit)
                        : "then   the island reads its file again: `rubicon settings reload`, SIGHUP, or its start");
  return ended(out, kGood);
}

Result<int> enable(const Settings& settings, EnableOptions options) {
  const auto path = file_of(options.island);
  if (!path) return fail(path.error());
  const auto folder = fs::path(*path).parent_path();
  if (options.tokens.empty()) options.tokens = fs::path(*path).stem().string() + ".tokens";
  auto page = page_in(*path);
  if (!page) return fail(page.error());
  if (!*page || !(*page)->tokens) {
    const auto before = text_of(*path);
    if (!before) return fail(before.error());
    const auto text = with_page(*path, *before, options);
    if (!text) return fail(text.error());
    if (auto done = replace(*path, *before, *text); !done) return fail(done.error());
    page = page_in(*path);
    if (!page) return fail(page.error());
  }
  if (!*page || !(*page)->tokens)
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: expected `web: {{tokens: {{file: {}}}}}`", *path, options.tokens));
  const auto tokens = base::resolve_path(folder.string(), *(*page)->tokens);
  const auto token = token_for(tokens, options.name);
  if (!token) return fail(token.error());
  return tell(settings, *path, **page, tokens, options.name, *token);
}

int run(const Settings& settings, const EnableOptions& options) {
  const auto done = enable(settings, options);
  if (done) return *done;
  const bool may_not = done.error().code == ErrorCode::kRefused && ::geteuid() != 0;
  print_error(done.error().text +
              (may_not ? fmt::format("; as root: sudo rubicon web enable {}", options.island) : ""));
  return done.error().code == ErrorCode::kInvalid ? kUsage : kFailed;
}

std::string check_listen(const std::string& text) {
  return config::parse_web_listen(text) ? std::string() : text + ": expected an IP address and a port";
}

}  // namespace

void add_web_enable(Cli& cli, CLI::App* web) {
  const auto options = std::make_shared<EnableOptions>();
  auto* app =
      cli.command({"enable", "Give an island its page: an address and a token, which it prints",
                   "  sudo rubicon web enable home                     # /etc/rubicon/home.yaml\n"
                   "  rubicon web enable examples/motes.yaml --listen 127.0.0.1:8700\n"
                   "It writes `web:` into the file, if that is not there, after `rubicon-proxy check`; the file\n"
                   "of before stays beside it as FILE.previous. Again it changes nothing.\n",
                   web},
                  [options](const Settings& settings) { return run(settings, *options); });
  app->add_option("ISLAND", options->island, "name of a file in /etc/rubicon, or a path; default: the only one there");
  app->add_option("--name", options->name, "who gets the token")->capture_default_str();
  app->add_option("--listen", options->listen, "IP address and port, where the file has none")
      ->check(check_listen)
      ->capture_default_str();
  app->add_option("--tokens", options->tokens, "file of the tokens, where the file has none; default: ISLAND.tokens");
}

}  // namespace rubicon::cli
