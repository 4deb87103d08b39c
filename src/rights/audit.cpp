#include "rights/audit.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>
#include <tuple>
#include <utility>

#include "base/log.h"
#include "base/own_file.h"
#include "base/text.h"
#include "model/json_members.h"
#include "model/json_text.h"
#include "rubicon/key.hpp"

namespace rubicon::rights {

/// The place of an audit: the newest lines are in `file`, older ones in `file.1` and so on.

/// Renames a file back that a crash left under the name of check_place().
void restore(const std::string& file);

/// Whether the system lets this file be renamed, as rotation needs it: renames it and back. kRefused: no, and why.
Result<void> check_place(const std::string& file);

/// Renames `file` to `file.1`, the one before to `file.2`, up to `file.<older>`, whose content is lost, and returns a
/// new `file`, which is open for appending. Nothing is renamed where the new one cannot be made.
Result<base::OwnFile> rotate(const std::string& file, int older);

namespace {

namespace fs = std::filesystem;

/// The next `file`, until the others have their names.
std::string name_of_new(const std::string& file) {
  return file + ".new";
}

bool is_there(const std::string& file) {
  std::error_code error;
  return fs::exists(fs::symlink_status(file, error));
}

Result<void> rename(const std::string& from, const std::string& to) {
  std::error_code error;
  fs::rename(from, to, error);
  if (!error) return {};
  return fail(ErrorCode::kRefused, fmt::format("{}: cannot be renamed to {}: {}", from, to, error.message()));
}

}  // namespace

void restore(const std::string& file) {
  std::error_code error;
  const bool is_left = fs::symlink_status(name_of_new(file), error).type() == fs::file_type::regular;
  if (!is_there(file) && is_left) std::ignore = rename(name_of_new(file), file);
}

Result<void> check_place(const std::string& file) {
  const auto other = name_of_new(file);
  if (auto done = rename(file, other); !done)
    return fail(done.error().code,
                done.error().text + "; expected a place for an audit, which keeps its older lines in further files");
  return rename(other, file);
}

Result<base::OwnFile> rotate(const std::string& file, int older) {
  auto made = base::OwnFile::open(name_of_new(file), O_WRONLY | O_APPEND | O_TRUNC);
  if (!made) return made;
  const auto name = [&](int age) { return age == 0 ? file : fmt::format("{}.{}", file, age); };
  for (int age = older; age > 0 && is_there(file); --age) {
    if (!is_there(name(age - 1))) continue;
    if (auto done = rename(name(age - 1), name(age)); !done) return fail(std::move(done.error()));
  }
  if (auto done = rename(name_of_new(file), file); !done) return fail(std::move(done.error()));
  return made;
}

void RequestLog::write(std::string_view text) {
  const auto now = scheduler_.now();
  if (window_ == SteadyTime::min() || now - window_ >= kWindow) {
    window_ = now;
    logged_ = 0;
  }
  if (++logged_ <= kLines) return log_.info(text);
  if (more_++ > 0) return;
  end_ = scheduler_.at(window_ + kWindow, [this] {
    log_.info(fmt::format("{} more {}{}", std::exchange(more_, 0), what_,
                          where_.empty() ? "" : ", which " + where_ + " names"));
  });
}

RefusalLimit::Name& RefusalLimit::name(std::string_view who, SteadyTime now) {
  if (const auto known = names_.find(who); known != names_.end()) return known->second;
  if (names_.size() >= kMaxNameCount)
    std::erase_if(names_, [now](const auto& one) { return one.second.more == 0 && now - one.second.hour >= kHour; });
  const bool has_room = names_.size() < kMaxNameCount;
  return names_.try_emplace(std::string(has_room ? who : kOthers), Name{now, now, {}, 0, 0, 0}).first->second;
}

bool RefusalLimit::allow(std::string_view who) {
  const auto now = scheduler_.now();
  auto& one = name(who, now);
  if (now - one.second >= kSecond) one = {now, one.hour, one.report, 0, one.in_hour, one.more};
  if (now - one.hour >= kHour) {
    one.hour = now;
    one.in_hour = 0;
  }
  if (now - hour_ >= kHour) {
    hour_ = now;
    in_hour_ = 0;
  }
  const bool has_hour = one.in_hour < kPerHour && in_hour_ < kAllPerHour;
  if (one.in_second < kPerSecond && has_hour) {
    ++one.in_second;
    ++one.in_hour;
    ++in_hour_;
    return true;
  }
  if (one.more++ == 0) {
    one.report = has_hour ? one.second + kSecond : now + kPause;
    plan();
  }
  return false;
}

void RefusalLimit::plan() {
  auto next = SteadyTime::max();
  for (const auto& [who, one] : names_) {
    if (one.more > 0) next = std::min(next, one.report);
  }
  if (next == SteadyTime::max()) return;
  timer_ = scheduler_.at(next, [this] { report(scheduler_.now()); });
}

void RefusalLimit::report(SteadyTime now) {
  for (auto& [who, one] : names_) {
    if (one.more > 0 && one.report <= now) more_(who, std::exchange(one.more, 0));
  }
  plan();
}

void RefusalLimit::flush() {
  report(SteadyTime::max());
}

namespace {

/// Lines that wait for the end of the turn; more are written at once.
constexpr std::size_t kMaxWaitingCount = 256UL * 1024;
/// Bytes of a value that are searched for secrets.
constexpr std::size_t kLookedAt = 1024;

/// At most so many bytes, cut after a character.
std::string_view beginning(std::string_view text, std::size_t most) {
  if (text.size() <= most) return text;
  std::size_t end = 0;
  while (true) {
    const auto length = base::first_character(text.substr(end)).size();
    if (end + length > most) return text.substr(0, end);
    end += length;
  }
}

void add_text(std::string_view name, std::string_view text, std::string& out,
              std::size_t most = AuditFile::kTextBytes) {
  base::append(out, ",\"{}\":", name);
  model::append_json(beginning(text, most), out);
}

/// `proxy.wsn-1.7.property.password-1.command`
bool has_secret_part(std::string_view key) {
  for (const auto part : model::key_parts(key)) {
    if (base::names_secret(part) || base::names_secret(part.substr(0, part.rfind('-')))) return true;
  }
  return false;
}

std::uint64_t lines_in(std::string_view text) {
  return static_cast<std::uint64_t>(std::count(text.begin(), text.end(), '\n'));
}

std::string begin_line(WallTime now) {
  std::string text = "{\"t\":";
  model::append_seconds(now, text);
  return text;
}

}  // namespace

AuditFile::AuditFile(AuditOptions options, Scheduler& scheduler, Log log, Log lines)
    : options_(std::move(options)),
      scheduler_(scheduler),
      log_(std::move(log)),
      refusals_(scheduler, [this](std::string_view who, std::uint64_t count) { more(who, count); }),
      accepted_log_(scheduler, lines, "accepted requests", options_.file),
      refused_log_(scheduler, std::move(lines), "refused requests", options_.file),
      at_end_(scheduler, [this] { flush(); }) {
  hide();
}

Result<std::unique_ptr<AuditFile>> AuditFile::open(AuditOptions options, Scheduler& scheduler, Log log, Log lines) {
  std::unique_ptr<AuditFile> made(new AuditFile(std::move(options), scheduler, std::move(log), std::move(lines)));
  if (auto opened = made->open_file(); !opened) return fail(std::move(opened.error()));
  return made;
}

AuditFile::~AuditFile() {
  refusals_.flush();
  flush();
}

Result<void> AuditFile::open_file() {
  if (options_.file.empty()) return {};
  restore(options_.file);
  auto file = base::OwnFile::open(options_.file, O_WRONLY | O_APPEND);
  if (!file) return fail(std::move(file.error()));
  struct stat about {};
  const bool is_file = ::fstat(file->get(), &about) == 0 && S_ISREG(about.st_mode);
  if (!is_file)
    return fail(ErrorCode::kInvalid, options_.file + ": is not a file, expected a file for the audit, or nothing");
  if (auto good = check_place(options_.file); !good) return good;
  file_ = std::move(*file);
  bytes_ = static_cast<std::uint64_t>(about.st_size);
  return {};
}

void AuditFile::reopen() {
  flush();
  if (auto opened = open_file(); !opened)
    log_.warning(fmt::format("{}; the audit continues in the file that is open", opened.error().text));
}

void AuditFile::change(AuditOptions options) {
  options_.hide = std::move(options.hide);
  options_.size = options.size;
  hide();
}

/// The patterns are those of rules, so rules find them.
void AuditFile::hide() {
  hidden_ = MemberRights();
  if (options_.hide.empty()) return;
  Rule rule{{std::string(kEverybody)}, {}, options_.hide};
  std::transform(rule.keys.begin(), rule.keys.end(), rule.keys.begin(), kept_key);
  rule.may.add(Right::kRead);
  hidden_.add(rule, 0);
}

bool AuditFile::is_hidden(std::string_view key) const {
  return has_secret_part(key) || hidden_.find(key).granted.has(Right::kRead);
}

/// Refusals quote values.
std::string AuditFile::why_of(const AuditLine& line) const {
  if (is_hidden(line.key)) return std::string(line.kind);
  return std::string(beginning(base::masked(beginning(line.why, kLookedAt)), kWhyBytes));
}

std::string AuditFile::text_of(const AuditLine& line) const {
  auto text = begin_line(scheduler_.wall_now());
  add_text("who", line.who.name, text);
  base::append(text, ",\"id\":{}", number(line.component));
  add_text("host", line.host, text);
  add_text("verb", line.verb, text);
  add_text("key", line.key, text);
  if (is_hidden(line.key)) {
    text += ",\"hidden\":true";
  } else {
    add_text("value", base::masked(beginning(line.value, kLookedAt)), text, kValueBytes);
  }
  add_text("verdict", line.accepted ? "accepted" : "refused", text);
  if (!line.who.through.empty()) add_text("through", line.who.through, text);
  add_text("why", why_of(line), text, kWhyBytes);
  return text + "}\n";
}

/// What others send may be long.
void AuditFile::write(const AuditLine& whole) {
  if (!whole.accepted) ++counters_.refused;
  const auto& who = whole.who;
  if (!whole.accepted && !refusals_.allow(beginning(who.through.empty() ? who.name : who.through, kTextBytes))) return;
  auto line = whole;
  line.key = beginning(whole.key, kTextBytes);
  line.verb = beginning(whole.verb, kTextBytes);
  tell(line);
  add(text_of(line));
}

/// What follows a flood: how many of its refusals have no line.
void AuditFile::more(std::string_view who, std::uint64_t count) {
  auto text = begin_line(scheduler_.wall_now());
  add_text("who", who, text);
  base::append(text, ",\"verdict\":\"refused\",\"more\":{}}}\n", count);
  add(std::move(text));
  refused_log_.write(fmt::format("{} more refusals of {}", count, base::one_line(who)));
}

/// Without values.
void AuditFile::tell(const AuditLine& line) {
  const auto why = line.quotes ? std::string(line.kind) : why_of(line);
  auto& log = line.accepted ? accepted_log_ : refused_log_;
  log.write(base::one_line(fmt::format("{} {} {}: {}{}{}", beginning(line.who.name, kTextBytes), line.verb, line.key,
                                       line.accepted ? "accepted" : "refused", why.empty() ? "" : ": ", why)));
}

void AuditFile::add(std::string text) {
  if (options_.file.empty()) return;
  waiting_ += text;
  if (waiting_.size() >= kMaxWaitingCount) return flush();
  at_end_.request();
}

void AuditFile::flush() {
  if (waiting_.empty()) return;
  auto lines = std::exchange(waiting_, {});
  struct stat about {};
  if (::fstat(file_.get(), &about) == 0) bytes_ = static_cast<std::uint64_t>(about.st_size);  // others may truncate it
  const auto room = make_room(lines.size());
  if (lost_since_ > 0) lines = begin_line(scheduler_.wall_now()) + fmt::format(",\"lost\":{}}}\n", lost_since_) + lines;
  if (!room) return note_lost(room.error(), lines);
  if (auto written = append(lines); !written) return note_lost(written.error(), lines);
  if (const auto lost = std::exchange(lost_since_, 0); lost > 0)
    log_.warning(fmt::format("{}: is written again; {} lines were lost", options_.file, lost));
}

/// A line is in the file as a whole or not at all.
Result<void> AuditFile::append(std::string_view lines) {
  auto written = file_.write(lines, options_.file);
  if (written) {
    bytes_ += lines.size();
  } else {
    std::ignore = ::ftruncate(file_.get(), static_cast<off_t>(bytes_));
  }
  return written;
}

void AuditFile::note_lost(const Error& why, std::string_view lines) {
  const auto lost = lines_in(lines) - (lost_since_ > 0 ? 1 : 0);
  if (lost_since_ == 0) log_.error(fmt::format("{}; lines of the audit are lost until it can be written", why.text));
  lost_since_ += lost;
  counters_.lost += lost;
}

/// Before lines are lost, the present file grows.
Result<void> AuditFile::make_room(std::size_t bytes) {
  if (bytes_ == 0 || bytes_ + bytes <= options_.size / (kOlderAuditFiles + 1)) return {};
  auto made = rotate(options_.file, kOlderAuditFiles);
  if (made) {
    file_ = std::move(*made);
    bytes_ = 0;
    is_stuck_ = false;
    return {};
  }
  if (!std::exchange(is_stuck_, true))
    log_.error(fmt::format("{}; the audit goes on in the file that is open", made.error().text));
  return bytes_ + bytes <= options_.size ? Result<void>() : fail(std::move(made.error()));
}

namespace {

bool matches(const AuditQuery& query, const nlohmann::json& line) {
  const auto time = model::time_from_seconds(model::number_of(line, "t"));
  const bool is_in_time = query.from <= time && time < query.to;
  const bool is_of_name = query.who.empty() || model::text_of(line, "who") == query.who;
  return is_in_time && is_of_name && (!query.refused_only || model::text_of(line, "verdict") == "refused");
}

AuditRead read_one(std::istream& file, const AuditQuery& query,
                   const std::function<void(std::string_view line)>& call) {
  AuditRead read;
  for (std::string line; std::getline(file, line);) {
    if (!file.eof()) read.end += line.size() + 1;
    const auto tree = model::parse_json(line);
    if (!tree.is_object() || !tree.contains("t")) {
      read.damaged += line.empty() ? 0U : 1U;
    } else if (matches(query, tree)) {
      call(line);
    }
  }
  return read;
}

}  // namespace

Result<AuditRead> read_audit(const std::string& file, const AuditQuery& query,
                             const std::function<void(std::string_view line)>& call) {
  AuditRead all;
  bool any = false;
  for (int age = kOlderAuditFiles; age >= 0; --age) {
    const auto name = age == 0 ? file : fmt::format("{}.{}", file, age);
    errno = 0;
    std::ifstream lines(name, std::ios::binary);
    if (!lines && errno == ENOENT) continue;
    if (!lines) return fail(ErrorCode::kRefused, fmt::format("{}: cannot be read: {}", name, std::strerror(errno)));
    any = true;
    const auto one = read_one(lines, query, call);
    all = {all.damaged + one.damaged, age == 0 ? one.end : 0};
  }
  if (!any) return fail(ErrorCode::kNotFound, fmt::format("{}: there is no such file, expected an audit log", file));
  return all;
}

}  // namespace rubicon::rights
