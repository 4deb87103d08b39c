#include "console/live_console.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <csignal>
#include <cstdio>
#include <optional>
#include <utility>

#include "console/draw_pace.h"
#include "console/strokes.h"

namespace rubicon::console {

namespace {

/// A terminal sends the rest of a key's sequence sooner.
constexpr Duration kEscapePause = std::chrono::milliseconds(50);

// xterm: ctlseqs.ms; ECMA-48. The alternate screen leaves what was on the terminal; without wrapping, a character that
// is wider than we think spoils its own line only.
constexpr const char* kBegin = "\x1b[?1049h\x1b[?7l";
constexpr const char* kEnd = "\x1b[0m\x1b[?7h\x1b[?1049l";

ScreenSize screen_size() {
  winsize size{};
  if (::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) < 0 || size.ws_row == 0) return {};
  return {size.ws_row, size.ws_col};
}

/// Keys come one by one and unseen; signals as before, but for the one that would stop the island (Ctrl-Z).
class RawKeys {
 public:
  RawKeys() : known_(::tcgetattr(STDIN_FILENO, &before_) == 0) {
    if (!known_) return;
    auto raw = before_;
    raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO | IEXTEN);
    raw.c_cc[VSUSP] = _POSIX_VDISABLE;
    ::tcsetattr(STDIN_FILENO, TCSADRAIN, &raw);
  }
  ~RawKeys() {
    if (known_) ::tcsetattr(STDIN_FILENO, TCSADRAIN, &before_);
  }
  RawKeys(const RawKeys&) = delete;
  RawKeys& operator=(const RawKeys&) = delete;

 private:
  termios before_{};
  bool known_;
};

}  // namespace

bool owns_terminal() {
  return ::isatty(STDOUT_FILENO) == 1 && ::tcgetpgrp(STDOUT_FILENO) == ::getpgrp();
}

struct LiveConsole::Content {
  Content(Context some, LiveTable a_table)
      : context(std::move(some)),
        table(std::move(a_table)),
        resized(context.loop.context(), SIGWINCH),
        pace(context.loop.scheduler(), [this] { return draw(); }) {
    if (::isatty(STDERR_FILENO) == 1) context.log.hold();
    await_resize();
    pace.ask();
  }

  void await_resize() {
    resized.async_wait([this](const boost::system::error_code& error, int) {
      if (error) return;
      pace.ask();
      await_resize();
    });
  }

  void take(std::string_view bytes) {
    for (const auto& stroke : reader.take(bytes)) press(stroke);
    settle = {};
    if (reader.pending()) {
      settle = context.loop.scheduler().after(kEscapePause, [this] {
        for (const auto& stroke : reader.settle()) press(stroke);
        pace.ask();
      });
    }
    pace.ask();
  }

  void press(const Stroke& stroke) {
    if (stroke.key == Stroke::Key::kRedraw) drawn = {0, 0};
    const auto line = table.press(stroke);
    if (!line) return;
    last_answer.clear();
    context.log.note("> " + *line);
    context.command(*line);
  }

  Duration draw() {
    auto& scheduler = context.loop.scheduler();
    const auto began = scheduler.now();
    const auto size = screen_size();
    const auto frame = table.frame(scheduler.wall_now(), size, last_answer);
    std::string text = begun ? "" : kBegin;
    if (size.rows != drawn.rows || size.columns != drawn.columns) text += "\x1b[2J";
    for (std::size_t i = 0; i < frame.lines.size(); ++i)
      text += fmt::format("\x1b[{};1H{}\x1b[0m", i + 1, frame.lines[i]);
    text += fmt::format("\x1b[{};{}H", frame.lines.size(), frame.cursor_column);
    if (context.output.screen(std::move(text))) {
      begun = true;
      drawn = size;
    }
    return scheduler.now() - began;
  }

  Context context;
  LiveTable table;
  RawKeys keys;
  boost::asio::signal_set resized;
  StrokeReader reader;
  std::unique_ptr<ConsoleReader> input;
  Timer settle;
  DrawPace pace;
  bool begun = false;
  ScreenSize drawn{0, 0};  ///< of the last screen that was written
  std::string last_answer;
};

LiveConsole::LiveConsole(Context context, LiveTable table)
    : content_(std::make_unique<Content>(std::move(context), std::move(table))) {}

LiveConsole::~LiveConsole() {
  auto& log = content_->context.log;
  content_.reset();
  std::fputs(kEnd, stdout);
  std::fflush(stdout);
  log.release();
}

void LiveConsole::listen() {
  if (content_->input || ::isatty(STDIN_FILENO) != 1) return;
  ConsoleReader::Calls calls;
  calls.bytes = [this](std::string_view bytes) { content_->take(bytes); };
  calls.pause = [] { return false; };
  calls.end = [] {};  // there is still something to show
  content_->input =
      std::make_unique<ConsoleReader>(content_->context.loop.context(), STDIN_FILENO, 0, std::move(calls));
}

void LiveConsole::answer(std::string line) {
  content_->context.log.note(line);
  content_->last_answer = std::move(line);
  content_->pace.ask();
}

}  // namespace rubicon::console
