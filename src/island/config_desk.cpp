#include "island/config_desk.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <tuple>
#include <utility>

#include "base/own_file.h"
#include "config/yaml.h"
#include "island/config_edit.h"
#include "model/json_members.h"
#include "rubicon/key.hpp"

namespace rubicon::island {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view kUndo = "undo";
constexpr std::size_t kMaxOptions = 64 * 1024;

/// Links lead to the file itself, which is replaced.
std::string real_path(const std::string& path) {
  std::error_code error;
  const auto real = fs::canonical(path, error);
  return error ? path : real.string();
}

Result<std::string> read_whole(const std::string& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error))
    return fail(ErrorCode::kNotFound,
                fmt::format("{}: {}", path, error ? error.message() : std::string("not a regular file")));
  if (fs::file_size(path, error) > config::kMaxYamlBytes)
    return fail(ErrorCode::kOutOfRange, fmt::format("{}: larger than {} bytes", path, config::kMaxYamlBytes));
  std::ifstream file(path, std::ios::binary);
  std::string text(std::istreambuf_iterator<char>(file), {});
  if (!file.is_open() || file.bad()) return fail(ErrorCode::kIo, fmt::format("{}: {}", path, std::strerror(errno)));
  return text;
}

/// A new file with the permissions of another one.
Result<void> write_new(const std::string& path, std::string_view text, const std::string& like) {
  const auto file = base::OwnFile::open(path, O_WRONLY | O_EXCL);
  if (!file) return fail(file.error());
  struct stat about {};
  if (::stat(like.c_str(), &about) == 0) {
    std::ignore = ::fchown(file->get(), static_cast<uid_t>(-1), about.st_gid);  // as far as this user may
    ::fchmod(file->get(), about.st_mode & 0777U);
  }
  auto written = file->write(text, path);
  if (written && ::fsync(file->get()) != 0)
    written = fail(ErrorCode::kIo, fmt::format("{}: {}", path, std::strerror(errno)));
  return written;
}

/// Complete or not at all.
Result<void> put(const std::string& path, std::string_view text, const std::string& like) {
  const auto fresh = fmt::format("{}.{}.new", path, ::getpid());
  std::error_code error;
  fs::remove(fresh, error);
  auto written = write_new(fresh, text, like);
  if (written) {
    fs::rename(fresh, path, error);
    if (!error) return {};
    written = fail(ErrorCode::kIo, fmt::format("{}: cannot be written: {}", path, error.message()));
  }
  fs::remove(fresh, error);
  return written;
}

/// A file that goes with this.
class Removed {
 public:
  explicit Removed(std::string path) : path_(std::move(path)) {}
  ~Removed() {
    std::error_code error;
    if (!path_.empty()) fs::remove(path_, error);
  }
  Removed(const Removed&) = delete;
  Removed& operator=(const Removed&) = delete;
  void keep() { path_.clear(); }

 private:
  std::string path_;
};

Error expected(std::string_view member, std::string_view what) {
  return {ErrorCode::kInvalid, fmt::format("{}: expected {}", member, what)};
}

}  // namespace

std::string_view ConfigChange::word() const {
  return kind == Kind::kAdd ? "add" : kind == Kind::kImport ? "import" : kUndo;
}

bool is_config_change(std::string_view text) {
  return text == kUndo || text.starts_with('{');
}

Result<ConfigChange> read_config_change(std::string_view text) {
  ConfigChange change;
  if (text == kUndo) return change;
  const auto tree = model::object_of(text);
  for (const auto& [name, value] : tree.items()) {
    const bool is_flag = name == "try";
    if (!is_flag && name != "do" && name != "network" && name != "options" && name != "groups")
      return fail(expected(name, "do, network, options, groups or try"));
    if (is_flag ? !value.is_boolean() : !value.is_string())
      return fail(expected(name, is_flag ? "true or false" : "a text"));
  }
  change.try_only = model::flag_of(tree, "try");
  const auto what = model::text_of(tree, "do");
  if (what == kUndo) return change;
  if (what != "add" && what != "import") return fail(expected("do", "add, import or undo"));
  change.kind = what == "add" ? ConfigChange::Kind::kAdd : ConfigChange::Kind::kImport;
  change.network = model::text_of(tree, "network");
  change.options = model::text_of(tree, "options");
  change.groups = model::text_of(tree, "groups");
  if (change.network.empty()) return fail(expected("network", "its name"));
  if (change.kind == ConfigChange::Kind::kAdd && change.options.empty())
    return fail(expected("options", "a map in YAML, such as {type: dummy}"));
  if (change.options.size() > kMaxOptions)
    return fail(expected("options", fmt::format("at most {} bytes", kMaxOptions)));
  if (change.kind == ConfigChange::Kind::kImport && (change.groups.empty() || !change.options.empty()))
    return fail(expected("groups", "a group file, and no options"));
  return change;
}

Result<std::string> ConfigDesk::read() const {
  return read_whole(file_);
}

void ConfigDesk::took(std::string_view text) {
  in_force_ = std::hash<std::string_view>()(text);
}

Result<void> ConfigDesk::check_in_force(const std::string& text) const {
  if (std::hash<std::string_view>()(text) == in_force_) return {};
  return fail(ErrorCode::kRefused,
              fmt::format("{} was changed and is not in force: reload it first, then it can be changed here", file_));
}

std::string ConfigDesk::previous_path() const {
  return real_path(file_) + ".previous";
}

std::string ConfigDesk::why_fixed() const {
  const auto folder = fs::path(real_path(file_)).parent_path();
  const auto path = folder.empty() ? std::string(".") : folder.string();
  return ::faccessat(AT_FDCWD, path.c_str(), W_OK, AT_EACCESS) == 0 ? std::string()
                                                                    : fmt::format("{}: {}", path, std::strerror(errno));
}

/// A name that nothing in the folder of the configuration has.
std::string ConfigDesk::fresh_groups(const std::string& network) const {
  const auto folder = fs::path(file_).parent_path();
  auto name = network + ".groups.yaml";
  std::error_code error;
  for (int number = 2; fs::exists(fs::symlink_status(folder / name, error)); ++number)
    name = fmt::format("{}.groups-{}.yaml", network, number);
  return name;
}

Result<std::string> ConfigDesk::changed(const std::string& text, const ConfigChange& change,
                                        const std::string& groups) const {
  auto next = Result<std::string>(text);
  if (change.kind == ConfigChange::Kind::kAdd) next = with_network(text, file_, change.network, change.options);
  if (next && !change.groups.empty()) next = with_option(*next, file_, change.network, "import", groups);
  return next;
}

/// The group file of an attempt goes with it. It is beside the others where that is possible: other users may write to
/// the folder of temporary files.
Result<ConfigDesk::Lines> ConfigDesk::plan_with_groups(const std::string& text, const ConfigChange& change) const {
  std::error_code error;
  const auto folder = why_fixed().empty() ? fs::path(real_path(file_)).parent_path() : fs::temp_directory_path(error);
  const auto path = (fs::absolute(folder, error) / fmt::format(".rubicon-{}.groups.yaml", ::getpid())).string();
  fs::remove(path, error);
  const Removed removed(change.groups.empty() ? std::string() : path);
  if (!change.groups.empty()) {
    if (auto written = write_new(path, change.groups, file_); !written) return fail(written.error());
  }
  const auto next = changed(text, change, path);
  return next ? calls_.plan(*next) : fail(next.error());
}

/// For people, whether or not it can be inserted.
std::string ConfigDesk::patch_of(const ConfigChange& change, const std::string& groups) {
  if (groups.empty()) return network_text(change.network, change.options);
  const auto import = fmt::format("import: {}\n", scalar_text(groups));
  if (!change.options.starts_with('{')) return network_text(change.network, import + change.options);
  return fmt::format("{}    # and in it: {}", network_text(change.network, change.options), import);
}

Result<ConfigDesk::Lines> ConfigDesk::carry_out(const ConfigChange& change) {
  patch_.clear();
  const auto text = read();
  if (!text) return fail(text.error());
  const bool undoes = change.kind == ConfigChange::Kind::kUndo;
  const auto groups = change.groups.empty() ? std::string() : fresh_groups(change.network);
  if (!undoes) patch_ = patch_of(change, groups);
  if (auto good = check_in_force(*text); !good) return fail(good.error());
  if (undoes) return undo(*text, change.try_only);
  if (change.kind == ConfigChange::Kind::kAdd && calls_.has_network(change.network))
    return fail(ErrorCode::kDuplicate,
                fmt::format("the island has a network {} already, expected another name", change.network));
  auto planned = plan_with_groups(*text, change);
  if (!planned || change.try_only) return planned;
  if (const auto why = why_fixed(); !why.empty()) return fail(fixed(why));
  return apply(*text, change, groups);
}

Error ConfigDesk::fixed(const std::string& why) {
  return {ErrorCode::kRefused, fmt::format("the file cannot be changed here ({}): insert the patch yourself", why)};
}

Result<ConfigDesk::Lines> ConfigDesk::apply(const std::string& text, const ConfigChange& change,
                                            const std::string& groups) {
  const auto next = changed(text, change, groups);
  if (!next) return fail(next.error());
  const auto path = groups.empty() ? std::string() : (fs::path(file_).parent_path() / groups).string();
  if (!path.empty()) {
    if (auto written = write_new(path, change.groups, file_); !written) return fail(written.error());
  }
  Removed removed(path);
  auto taken = replace(text, *next);
  if (taken) removed.keep();
  return taken;
}

/// The file as `text`; both files as they were where the island refuses it.
Result<ConfigDesk::Lines> ConfigDesk::replace(const std::string& before, const std::string& text) {
  const auto path = real_path(file_), previous = previous_path();
  const auto older = read_whole(previous);
  if (auto kept = put(previous, before, path); !kept) return fail(kept.error());
  auto written = put(path, text, path);
  auto taken = written ? calls_.reload() : Result<Lines>(fail(written.error()));
  if (taken) return taken;
  std::error_code error;
  auto back = written ? put(path, before, path) : Result<void>();
  if (back && older) back = put(previous, *older, path);
  if (back && !older) fs::remove(previous, error);
  if (!back) taken.error().text += "\n" + back.error().text;
  return taken;
}

Result<ConfigDesk::Lines> ConfigDesk::undo(const std::string& text, bool try_only) {
  auto before = read_whole(previous_path());
  if (!before) return fail(ErrorCode::kNotFound, fmt::format("there is no previous file: {}", before.error().text));
  auto planned = calls_.plan(*before);
  if (!planned || try_only) return planned;
  if (const auto why = why_fixed(); !why.empty()) return fail(fixed(why));
  return replace(text, *before);
}

ConfigFacts ConfigDesk::facts() const {
  std::error_code error;
  return {fs::path(file_).filename().string(), why_fixed(), fs::is_regular_file(previous_path(), error), patch_};
}

}  // namespace rubicon::island
