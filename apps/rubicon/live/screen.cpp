#include "apps/rubicon/live/screen.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <utility>

#include "apps/program/process.h"
#include "apps/rubicon/doctor/signs.h"
#include "apps/rubicon/live/view.h"
#include "model/point_keys.h"

namespace rubicon::cli::live {

void DrawPace::ask() {
  if (std::exchange(asked_, true)) return;
  due_ = scheduler_.at(std::max(earliest_, scheduler_.now()), [this] { draw(); });
}

void DrawPace::draw() {
  asked_ = false;
  const auto took = draw_();
  const auto now = scheduler_.now();
  earliest_ = now + kShare * took;
  due_ = scheduler_.at(std::max(earliest_, now + kIdle), [this] { draw(); });
}

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

/// Keys come one by one and unseen; signals as before, but for those that would leave the table on the terminal
/// (Ctrl-Z, Ctrl-\).
class RawKeys {
 public:
  RawKeys() : known_(::tcgetattr(STDIN_FILENO, &before_) == 0) {
    if (!known_) return;
    auto raw = before_;
    raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO | IEXTEN);
    raw.c_cc[VSUSP] = raw.c_cc[VQUIT] = _POSIX_VDISABLE;
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
  return ::isatty(STDIN_FILENO) == 1 && ::isatty(STDOUT_FILENO) == 1 && ::tcgetpgrp(STDOUT_FILENO) == ::getpgrp();
}

namespace {

/// Lines that were typed while a command runs.
constexpr std::size_t kMaxEntered = 100;
/// Between two counts of rates.
constexpr Duration kRound = std::chrono::seconds(2);

class Screen {
 public:
  Screen(Session& session, const ScreenOptions& options)
      : session_(session),
        options_(options),
        kept_(session.out()),
        table_(LiveSource(session.client().tuples(), options.island, session.settings().prefix), log_,
               place_text(session.settings().options)),
        pace_(session.client().scheduler(), [this] { return draw(); }) {
    auto& space = session.client().tuples();
    const model::IslandKey island{session.settings().prefix};
    values_ = space.subscribe({options.island, island.text + ".**"}, {.passive = options.is_passive},
                              [this](const Event& event) { count(event); });
    log_lines_ = space.subscribe({options.island, island.log_lines()}, {}, [this](const Event& event) { note(event); });
    begin_round();
    terminal_.write(kBegin);
  }
  ~Screen() {
    terminal_.write(kEnd);
    terminal_.flush();
  }
  Screen(const Screen&) = delete;
  Screen& operator=(const Screen&) = delete;

  int run() {
    Handle end;
    if (options_.length > Duration(0)) end = session_.client().after(options_.length, [this] { ended_ = true; });
    pace_.ask();
    while (!ended_ && !session_.interrupted() && !terminal_.broken()) {
      if (session_.turn(STDIN_FILENO)) read_keys();
      while (!entered_.empty() && !ended_) {
        const auto line = std::move(entered_.front());
        entered_.pop_front();
        execute(line);
      }
      take_answer();
    }
    return kGood;
  }

 private:
  void read_keys() {
    std::array<char, 4096> buffer;
    const auto count = ::read(STDIN_FILENO, buffer.data(), buffer.size());
    if (count == 0) ended_ = true;  // the terminal was closed
    if (count <= 0) return;
    for (const auto& stroke : reader_.take({buffer.data(), static_cast<std::size_t>(count)})) press(stroke);
    settle_.reset();
    if (reader_.pending()) {
      settle_ = session_.client().after(kEscapePause, [this] {
        for (const auto& stroke : reader_.settle()) press(stroke);
        pace_.ask();
      });
    }
    pace_.ask();
  }

  void press(const Stroke& stroke) {
    if (stroke.key == Stroke::Key::kRedraw) drawn_ = {0, 0};
    auto line = table_.press(stroke);
    if (line && entered_.size() < kMaxEntered) entered_.push_back(std::move(*line));
  }

  void execute(const std::string& line) {
    if (line == LiveView::kQuit) return void(ended_ = true);
    answer_.clear();
    log_.add({session_.now(), false, "> " + line});
    options_.command(line);
    pace_.ask();
  }

  /// Of a command, or a warning that came by itself.
  void take_answer() {
    auto text = kept_.take();
    text.erase(text.find_last_not_of('\n') + 1);
    if (text.empty()) return;
    for (std::string_view rest = text; !rest.empty();) {
      const auto line = rest.substr(0, rest.find('\n'));
      log_.add({session_.now(), false, std::string(line)});
      rest.remove_prefix(std::min(rest.size(), line.size() + 1));
    }
    answer_ = std::move(text);
    pace_.ask();
  }

  void count(const Event& event) {
    const auto& tuple = event.tuple;
    if (event.kind == EventKind::kSet && tuple.key.ends_with(".value"))
      table_.source().count(tuple.owner, tuple.key, session_.now());
  }

  void begin_round() {
    round_ = session_.client().after(kRound, [this] {
      table_.source().end_round(kRound);
      begin_round();
    });
  }

  void note(const Event& event) {
    if (event.kind != EventKind::kSet) return;
    for (auto& line : new_lines_.take(event.tuple).lines)
      log_.add({line.time, line.level == "warning" || line.level == "error",
                fmt::format("{}{}: {}",
                            options_.island || session_.client().islands().size() == 1
                                ? std::string()
                                : fmt::format("{} ", number(line.island)),
                            line.subject, line.text)});
    pace_.ask();
  }

  Duration draw() {
    if (session_.interrupted()) program::end_whenever_done();  // not before the terminal was given back
    take_answer();
    auto& scheduler = session_.client().scheduler();
    const auto began = scheduler.now();
    const auto size = screen_size();
    const auto frame = table_.frame(session_.now(), size, answer_);
    if (size.rows != drawn_.rows || size.columns != drawn_.columns) terminal_.write("\x1b[2J");
    for (std::size_t i = 0; i < frame.lines.size(); ++i)
      terminal_.write(fmt::format("\x1b[{};1H{}\x1b[0m", i + 1, frame.lines[i]));
    terminal_.write(fmt::format("\x1b[{};{}H", frame.lines.size(), frame.cursor_column));
    terminal_.flush();
    drawn_ = size;
    return scheduler.now() - began;
  }

  Session& session_;
  const ScreenOptions& options_;
  Kept kept_;
  LiveLog log_;
  NewLines new_lines_;
  LiveTable table_;
  RawKeys keys_;
  Output terminal_{STDOUT_FILENO};
  StrokeReader reader_;
  DrawPace pace_;
  Handle values_, log_lines_, settle_, round_;
  std::deque<std::string> entered_;
  std::string answer_;
  ScreenSize drawn_{0, 0};
  bool ended_ = false;
};

}  // namespace

int show_table(Session& session, const ScreenOptions& options) {
  session.catch_signals();
  return Screen(session, options).run();
}

}  // namespace rubicon::cli::live
