#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "console/console.h"
#include "console/live_log.h"
#include "console/live_table.h"
#include "transport/asio_scheduler.h"

namespace rubicon::console {

/// Whether this process may draw on the terminal of its standard output: it is one, and we are in its foreground.
bool owns_terminal();

/// The live table on the terminal: draws it, reads keys, follows its size. Owns the terminal while it lives and gives
/// it back as it was. The one place that knows terminals; never blocks the loop.
class LiveConsole {
 public:
  struct Context {
    transport::Loop& loop;
    ConsoleWriter& output;
    LiveLog& log;
    std::function<void(std::string_view line)> command;  ///< that was entered
  };
  /// All that `context` names must outlive it.
  LiveConsole(Context context, LiveTable table);
  ~LiveConsole();
  LiveConsole(const LiveConsole&) = delete;
  LiveConsole& operator=(const LiveConsole&) = delete;

  /// From now on strokes are taken; what was typed before waits.
  void listen();
  /// A line that the last command was answered with.
  void answer(std::string line);

 private:
  struct Content;
  std::unique_ptr<Content> content_;
};

}  // namespace rubicon::console
