#pragma once

#include <string>
#include <string_view>

namespace rubicon::cli {

/// Standard output: collected, written when flushed. A reader that goes ends the program quietly.
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
  /// Waits until the reader has taken everything, or a signal came.
  void flush();
  /// Nobody reads any more, or the disk is full; looks for that without writing, too.
  bool broken();
  /// The system's word for what went wrong; empty if nothing did, or the reader just went.
  const std::string& error() const { return error_; }

 private:
  int descriptor_;
  std::size_t width_ = 0, height_ = 0;
  bool terminal_ = false, colour_ = false, broken_ = false;
  std::string waiting_, error_;
};

/// A line on standard error, begun with the name of the program.
void say(std::string_view text);

/// Writes what is left. `code`; kFailed in place of kGood when it cannot be written, and why not on standard error.
int ended(Output& out, int code);

}  // namespace rubicon::cli
