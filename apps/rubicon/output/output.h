#pragma once

#include <string>
#include <string_view>
#include <utility>

namespace rubicon::cli {

/// Exit codes of the program; the same table is in `rubicon --help` and docs/cli.md.
enum ExitCode : int {
  kGood = 0,
  kFailed = 1,      ///< the network, a file, or (doctor) something is wrong
  kUsage = 2,       ///< the command line is wrong, or several tuples fit
  kRefused = 3,     ///< 3 to 7: how a command ended
  kNotDone = 4,     ///< failed
  kTimedOut = 5,    ///< timed-out
  kExpired = 6,     ///< expired
  kSuperseded = 7,  ///< superseded
  kNotThere = 8,    ///< no such owner, tuple or device
  kPartly = 9,      ///< `knx import`: the rest of the file was imported
  kNotGood = 10     ///< `get`: the value was shown, its quality is not good
};

/// The exit code of an outcome (docs/life-of-a-command.md); kFailed for an unknown word.
int exit_code_of(std::string_view state);

inline constexpr const char* kExitCodes =
    "Exit codes: 0 good; 1 failed; 2 wrong command line, or several tuples fit; how a command ended: 3 refused,\n"
    "4 failed, 5 timed-out, 6 expired, 7 superseded; 8 no such component, tuple or device; 9 a file was imported\n"
    "without the lines that have errors; 10 the value is shown, but its quality is not good.";

/// Buffered standard output. A reader that closes the pipe ends the program quietly.
class Output {
 public:
  explicit Output(int descriptor);

  /// Lines for people may be cut to this many characters; 0 = not a terminal, never cut.
  std::size_t width() const { return width_; }
  bool is_terminal() const { return terminal_; }
  /// A terminal, and the environment has no NO_COLOR (https://no-color.org).
  bool has_colour() const { return colour_ && !kept_; }

  void write(std::string_view text);
  void line(std::string_view text);
  /// Waits until everything is written, or a signal comes.
  void flush();
  /// Whether the reader closed the pipe or a write failed. Checks the pipe itself, also when nothing is buffered.
  bool broken();
  /// The system's text for a failed write; empty if none failed or the reader closed the pipe.
  const std::string& error() const { return error_; }

 private:
  friend class Kept;

  int descriptor_;
  std::size_t width_ = 0;
  std::string* kept_ = nullptr;
  bool terminal_ = false, colour_ = false, broken_ = false;
  std::string waiting_, error_;
};

/// While it lives, what `out` and print_error() would print is kept in this order, without colours, for a screen that
/// shows it. One per process.
class Kept {
 public:
  /// Of what is not taken, in bytes; the rest is dropped.
  static constexpr std::size_t kMaxByteCount = 1024 * 1024;

  /// `out` must outlive it.
  explicit Kept(Output& out);
  ~Kept();
  Kept(const Kept&) = delete;
  Kept& operator=(const Kept&) = delete;

  /// What was kept since the last call: lines with their ends.
  std::string take() { return std::exchange(text_, {}); }

 private:
  Output& out_;
  std::string text_;
};

/// Prints a line on standard error, with `rubicon: ` in front.
void print_error(std::string_view text);

/// Flushes. Returns `code`; kFailed in place of kGood, with the reason on standard error, if the output cannot be
/// written.
int ended(Output& out, int code);

}  // namespace rubicon::cli
