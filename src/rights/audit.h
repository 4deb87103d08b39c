#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/log.h"
#include "base/own_file.h"
#include "base/scheduler.h"
#include "rights/rights.h"
#include "tuples/judge.h"

namespace rubicon::rights {

/// One request of another process and how it ended.
struct AuditLine {
  const tuples::Member& who;
  OwnerId component{};
  std::string_view host;  ///< of the component, as it declares it; for the web server the address of the caller
  std::string_view verb;  ///< set, append, approve, send, read, demand
  std::string_view key;
  std::string_view value;
  bool accepted = false;
  std::string_view why;     ///< of a refusal
  std::string_view kind{};  ///< of a refusal: its code in words, which quotes nothing
  bool quotes = false;      ///< `why` is of the owner of the tuple and may quote the value
};

/// Where requests are recorded.
class Audit {
 public:
  virtual ~Audit() = default;
  virtual void write(const AuditLine& line) = 0;
};

/// Lines about requests in a log: at most kLines in kWindow, then how many more there were.
class RequestLog {
 public:
  static constexpr std::size_t kLines = 50;
  static constexpr Duration kWindow = std::chrono::seconds(10);

  /// `what`: `refused requests`. `where`: the file that has all of them; empty = there is none.
  RequestLog(Scheduler& scheduler, Log log, std::string_view what, std::string where)
      : scheduler_(scheduler), log_(std::move(log)), what_(what), where_(std::move(where)) {}

  /// `text` is one line.
  void write(std::string_view text);

 private:
  Scheduler& scheduler_;
  Log log_;
  std::string what_, where_;
  SteadyTime window_ = SteadyTime::min();
  std::uint64_t logged_ = 0, more_ = 0;
  Timer end_;
};

/// Decides which refusals get a line of their own, for each member that delivered requests, and counts the other
/// refusals. Bounded: beyond kMaxNameCount at a time all further names share one count.
class RefusalLimit {
 public:
  static constexpr std::size_t kMaxNameCount = 256;
  static constexpr std::uint64_t kPerSecond = 100;
  /// Of a flood that goes on for a day the files hold less than half: it does not push out what was accepted.
  static constexpr std::uint64_t kPerHour = 5'000, kAllPerHour = 10'000;
  static constexpr Duration kSecond = std::chrono::seconds(1);
  static constexpr Duration kHour = std::chrono::hours(1);
  /// How often the count of a name is written that used up its hour.
  static constexpr Duration kPause = std::chrono::minutes(1);
  static constexpr const char* kOthers = "others";

  /// `more`: so many refusals of that name got no line since the last call for it.
  RefusalLimit(Scheduler& scheduler, std::function<void(std::string_view who, std::uint64_t count)> more)
      : scheduler_(scheduler), more_(std::move(more)) {}

  /// False: it was counted.
  bool allow(std::string_view who);
  /// Reports all counts now.
  void flush();

 private:
  struct Name {
    SteadyTime second{}, hour{}, report{};  ///< begin of the second and the hour; when the count is written
    std::uint64_t in_second = 0, in_hour = 0, more = 0;
  };
  Name& name(std::string_view who, SteadyTime now);
  void report(SteadyTime now);
  void plan();

  Scheduler& scheduler_;
  std::function<void(std::string_view, std::uint64_t)> more_;
  std::map<std::string, Name, std::less<>> names_;
  SteadyTime hour_{};          ///< begin of the hour of all names
  std::uint64_t in_hour_ = 0;  ///< of all names
  Timer timer_;
};

struct AuditOptions {
  std::string file;                  ///< empty = lines go to the log only
  std::vector<std::string> hide{};   ///< tuples whose values are left out
  std::uint64_t size = 100'000'000;  ///< bytes of all files together
};

/// The newest lines are in `file`, older ones in `file.1` to `file.4`, each a fifth of the size.
inline constexpr int kOlderAuditFiles = 4;

/// Writes one line of JSON for each request (docs/rights.md), readable by its user and group only. Refusals beyond
/// RefusalLimit are counted in one line; accepted requests have a line each. The lines of a turn are written together
/// at its end: some microseconds, because the system takes them into its memory. Where it cannot (a full disk), the log
/// says so once, the lines are counted as lost, and the next turn tries again. Where no new file can be made, the
/// present one grows to the size of all of them. A log gets the lines too, by two RequestLogs: refusals do not push out
/// others.
class AuditFile final : public Audit {
 public:
  static constexpr std::size_t kValueBytes = 64, kWhyBytes = 512;
  /// Of each other text.
  static constexpr std::size_t kTextBytes = 255;

  /// `log` gets what concerns the audit itself, `lines` its lines: what that one keeps must be as closed to others as
  /// the file. The errors of OwnFile::open: the path is a symbolic link, its folder is missing, no permission. kRefused
  /// too: files cannot be renamed there.
  static Result<std::unique_ptr<AuditFile>> open(AuditOptions options, Scheduler& scheduler, Log log, Log lines);
  ~AuditFile() override;

  void write(const AuditLine& line) override;
  /// Another program renamed the file (logrotate): goes on in a new one. Where that cannot be made, in the old one.
  void reopen();
  /// Takes other values to hide, and another size, from now on. Another file needs a new AuditFile.
  void change(AuditOptions options);

  struct Counters {
    std::uint64_t refused = 0;  ///< refused requests, with those that got no line
    std::uint64_t lost = 0;     ///< lines that could not be written
  };
  const Counters& counters() const { return counters_; }

 private:
  AuditFile(AuditOptions options, Scheduler& scheduler, Log log, Log lines);
  Result<void> open_file();
  void hide();
  bool is_hidden(std::string_view key) const;
  std::string why_of(const AuditLine& line) const;
  std::string text_of(const AuditLine& line) const;
  void add(std::string text);
  void more(std::string_view who, std::uint64_t count);
  void tell(const AuditLine& line);
  void flush();
  Result<void> make_room(std::size_t bytes);
  Result<void> append(std::string_view lines);
  void note_lost(const Error& why, std::string_view lines);

  AuditOptions options_;
  MemberRights hidden_;  ///< the tuples of AuditOptions::hide are readable
  Scheduler& scheduler_;
  Log log_;
  base::OwnFile file_;
  std::uint64_t bytes_ = 0;  ///< of the present file
  std::string waiting_;
  Counters counters_;
  std::uint64_t lost_since_ = 0;  ///< lines lost since the last one that was written
  RefusalLimit refusals_;
  RequestLog accepted_log_, refused_log_;
  bool is_stuck_ = false;  ///< no new file could be made
  base::OncePerTurn at_end_;
};

/// Which lines a reader wants.
struct AuditQuery {
  std::string who{};  ///< empty = of all
  WallTime from{};
  WallTime to = WallTime::max();
  bool refused_only = false;
};
struct AuditRead {
  std::uint64_t damaged = 0;  ///< lines that are no audit lines
  std::uint64_t end = 0;      ///< of the newest file: behind its last whole line
};
/// Calls with each line that matches, as it stands in the files, oldest first: `file.4` to `file.1`, then `file`. Lines
/// that are no audit lines are left out. kNotFound: none of the files is there; kRefused: one of them may not be read.
Result<AuditRead> read_audit(const std::string& file, const AuditQuery& query,
                             const std::function<void(std::string_view line)>& call);

}  // namespace rubicon::rights
