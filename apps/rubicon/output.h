#pragma once

#include <string>
#include <string_view>

namespace rubicon::cli {

/// Buffered standard output. A reader that closes the pipe ends the program quietly.
class Output {
 public:
  explicit Output(int descriptor);

  /// Lines for people may be cut to this many characters; 0 = not a terminal, never cut.
  std::size_t width() const { return width_; }
  std::size_t height() const { return height_; }
  bool is_terminal() const { return terminal_; }
  /// A terminal, and the environment has no NO_COLOR (https://no-color.org).
  bool has_colour() const { return colour_; }

  void write(std::string_view text);
  void line(std::string_view text);
  /// Waits until everything is written, or a signal comes.
  void flush();
  /// Whether the reader closed the pipe or a write failed. Checks the pipe itself, also when nothing is buffered.
  bool broken();
  /// The system's text for a failed write; empty if none failed or the reader closed the pipe.
  const std::string& error() const { return error_; }

 private:
  int descriptor_;
  std::size_t width_ = 0, height_ = 0;
  bool terminal_ = false, colour_ = false, broken_ = false;
  std::string waiting_, error_;
};

/// Prints a line on standard error, with `rubicon: ` in front.
void print_error(std::string_view text);

/// Flushes. Returns `code`; kFailed in place of kGood, with the reason on standard error, if the output cannot be
/// written.
int ended(Output& out, int code);

}  // namespace rubicon::cli
