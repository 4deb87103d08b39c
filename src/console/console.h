#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace boost::asio {
class io_context;
}

namespace rubicon::console {

/// Standard output that never stops the loop: at most kMaxLines and about kMaxBytes wait for a slow reader, further
/// events are dropped and counted. The descriptor's flags, which other processes may share, are left alone.
class ConsoleWriter {
 public:
  static constexpr std::size_t kMaxLines = 10'000;
  static constexpr std::size_t kMaxBytes = 16UL * 1024 * 1024;

  ConsoleWriter(boost::asio::io_context& context, int descriptor, std::function<void()> closed);
  ~ConsoleWriter();

  /// False: no room, the line is dropped and counted.
  bool event(std::string line);
  /// Always taken; ask crowded() before making more.
  void answer(std::string line);

  bool crowded() const;
  bool empty() const;
  std::uint64_t dropped() const;
  /// Calls when everything is written (at once if it is).
  void when_empty(std::function<void()> call);

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

/// Standard input, line by line; pauses while asked to.
class ConsoleReader {
 public:
  struct Callbacks {
    std::function<void(std::string_view)> line;
    std::function<void()> too_long;
    std::function<void()> end;
    std::function<bool()> pause;  ///< true: ask again a little later
  };
  ConsoleReader(boost::asio::io_context& context, int descriptor, std::size_t max_line, Callbacks calls);
  ~ConsoleReader();

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace rubicon::console
