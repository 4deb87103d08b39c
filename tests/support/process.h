#pragma once

#include <sys/types.h>

#include <array>
#include <chrono>
#include <optional>
#include <string>
#include <vector>

namespace rubicon::support {

/// A program under test with pipes to its three standard streams, in a process group of its own. When destroyed, all of
/// the group is killed, also what the program left behind; when the test is killed, the program is.
class Process {
 public:
  explicit Process(std::vector<std::string> arguments);
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  void write(const std::string& text);
  void close_input();
  void close_output();
  void signal(int number) const;
  pid_t pid() const { return pid_; }
  /// Waits until it has read all its input and rests (a minute at most).
  bool has_settled() const;

  static constexpr std::chrono::seconds kPatience{60};
  /// The next line of standard output; nullopt at its end, or when it takes too long.
  std::optional<std::string> line(std::chrono::seconds patience = kPatience);
  /// The next line that contains this; nullopt as above.
  std::optional<std::string> line_with(const std::string& part);
  /// Waits for the end and gives the exit code; 128 + n for signal n, -1 if it did not end.
  int exit_code(std::chrono::seconds patience = kPatience);
  /// All of standard error so far; all there ever was after exit_code().
  std::string errors();
  /// Of the process, in kilobytes.
  long resident_kilobytes() const;
  /// Of the process.
  long open_descriptors() const;
  /// That the process used so far.
  std::chrono::milliseconds processor_time() const;

 private:
  bool fill(std::chrono::steady_clock::time_point deadline);

  pid_t pid_ = -1;
  int input_ = -1, output_ = -1, errors_ = -1;
  std::string pending_, error_text_;
  std::optional<int> code_;
};

/// Runs a program to its end, for which it has ten minutes after its last line: compilers and benches print little.
struct Outcome {
  int code = -1;
  std::string output, errors;
};
Outcome run_to_end(std::vector<std::string> arguments, const std::string& input = {});

}  // namespace rubicon::support
