#pragma once

#include <sys/types.h>
#include <termios.h>

#include <functional>
#include <string>
#include <vector>

namespace rubicon::support {

/// A program on a pseudo-terminal of its own, and what a terminal that knows cursor positions, erasing and UTF-8 would
/// show of it. Cells keep what was written into them until it is overwritten or erased, also when the size changes, as
/// in real terminals. Killed when destroyed.
class Terminal {
 public:
  Terminal(std::vector<std::string> arguments, int rows, int columns);
  ~Terminal();
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  void type(const std::string& keys) const;
  void resize(int rows, int columns);
  /// Reads until the screen is as wanted; false after a minute, or when the program ended.
  bool shows(const std::function<bool()>& wanted);
  bool shows(const std::string& text);

  /// The rows of the screen without blanks at their ends.
  std::vector<std::string> rows() const;
  std::string text() const;
  /// Everything that was ever written.
  const std::string& bytes() const { return bytes_; }
  /// What the terminal does with keys now, and before the program came.
  bool is_as_before() const;
  void signal(int number) const;
  /// Waits for the end (a minute at most): exit code, 128 + n for signal n, -1.
  int exit_code();

 private:
  bool read_some();
  /// Leaves the exit status to exit_code().
  bool has_ended() const;
  void put(const std::string& bytes);
  void sequence(const std::string& parameters, char last);

  pid_t pid_ = -1;
  int master_ = -1, slave_ = -1;
  termios before_{};
  std::size_t height_, width_;
  std::size_t row_ = 0, column_ = 0;
  std::vector<std::vector<std::string>> cells_;
  std::string bytes_, pending_;
};

}  // namespace rubicon::support
